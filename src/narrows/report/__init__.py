"""Pictures, pages and tables: what people look at before they read."""

from narrows.lazy import names_of_stub

__getattr__, __dir__, __all__ = names_of_stub(__name__, __file__)
