"""Names that load when they are first asked for: those that a package's stub (``__init__.pyi``) imports."""

import ast
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any


class _Package(ModuleType):
    """A package whose module of the same name does not hide a function: ``import package.f`` would set ``f`` to it."""

    def __setattr__(self, name: str, value: Any) -> None:
        if not (name in self.__lazy__ and value is sys.modules.get(f"{self.__name__}.{name}")):
            super().__setattr__(name, value)


def names_of_stub(package: str, file: str) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """Return ``__getattr__``, ``__dir__`` and ``__all__`` of a package whose stub says where its names come from."""
    lines = ast.parse(Path(file).with_suffix(".pyi").read_text(encoding="utf-8")).body
    imports = [line for line in lines if isinstance(line, ast.ImportFrom)]
    modules = {alias.name: line.module for line in imports for alias in line.names}
    # ``from . import room`` names a module itself, which may be set; ``from .room import name`` what is in it.
    vars(sys.modules[package])["__lazy__"] = {name for name, module in modules.items() if module}
    sys.modules[package].__class__ = _Package

    def load(name: str) -> Any:
        if name not in modules:
            raise AttributeError(f"module {package!r} has no attribute {name!r}", name=None, obj=None)
        module = modules[name]
        found = getattr(import_module(f"{package}.{module}"), name) if module else import_module(f"{package}.{name}")
        vars(sys.modules[package])[name] = found
        return found

    return load, lambda: sorted(modules), sorted(modules)
