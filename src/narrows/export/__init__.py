"""Export: a model in other languages, printed from the lines that simulation uses.

``nw.export(model, path)`` is ``nw.export.write``.
"""

import sys
from types import ModuleType
from typing import Any

from narrows.base.aliases import part_named
from narrows.export.exporters import EXPORTERS, LANGUAGES, to_language, write

__all__ = ["EXPORTERS", "LANGUAGES", "to_language", "write"]


def __getattr__(name: str) -> Any:
    return part_named(name, "export", __all__)


def __dir__() -> list[str]:
    return __all__


class _Export(ModuleType):
    __call__ = staticmethod(write)


sys.modules[__name__].__class__ = _Export
