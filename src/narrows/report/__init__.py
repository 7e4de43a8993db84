"""Figures, pages and tables."""

from typing import Any

import lazy_loader

from narrows.base.aliases import part_named

_loaded, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> Any:
    return _loaded(name) if name in __all__ else part_named(name, "report", __all__)
