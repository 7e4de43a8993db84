"""Every export format: one module of this folder each, registered by its presence."""

import pkgutil
from importlib import import_module

from narrows.export.exporter import Exporter

_FOUND: list[Exporter] = [
    import_module(f"{__name__}.{module.name}").EXPORTER for module in pkgutil.iter_modules(__path__)
]
# Formats of ``narrows export``, by name.
EXPORTERS: dict[str, Exporter] = {own.kind: own for own in _FOUND}
