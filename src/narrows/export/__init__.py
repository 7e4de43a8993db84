"""Export: a model out of Python, printed from the lines that its voyages are sailed by."""

from narrows.export.writing import write_c as write_c
