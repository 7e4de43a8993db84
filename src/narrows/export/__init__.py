"""Export: a model out of Python, printed from the lines that its voyages are sailed by."""

from narrows.export.writing import *  # noqa: F403  its functions are those of ``__all__`` there
