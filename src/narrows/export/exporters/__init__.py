"""Every kind of file that a model goes into: a module of this folder each, found by itself."""

import pkgutil
from importlib import import_module

from narrows.export.exporter import Exporter

_FOUND: list[Exporter] = [
    import_module(f"{__name__}.{module.name}").EXPORTER for module in pkgutil.iter_modules(__path__)
]
# What ``narrows export`` writes, by the kind that it is asked for.
EXPORTERS: dict[str, Exporter] = {own.kind: own for own in _FOUND}
