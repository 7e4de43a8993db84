"""A page of the API for each package, in the order of the data flow."""

import inspect
import pkgutil
import tomllib
from pathlib import Path
from typing import Any

import narrows
from narrows.ship.actuators import Part

_SAID: dict[str, list[str]] = {}
ROOT = Path(__file__).parents[2]
NOT_IMPORTED = tuple(f"narrows.codegen.kernels.{name}" for name in ("queue", "newton", "sensitivity"))
"""Source text that goes into compiled programs."""


def write_pages(source: Path) -> None:
    """Write the pages into reference/api, those of rooms that are gone removed."""
    folder = Path(source) / "reference" / "api"
    folder.mkdir(parents=True, exist_ok=True)
    pages = {f"{room}.rst": _page(room) for room in rooms()}
    pages["index.rst"] = _contents()
    for path in folder.glob("*.rst"):
        if path.name not in pages:
            path.unlink()
    for name, text in pages.items():
        if not (folder / name).exists() or (folder / name).read_text(encoding="utf-8") != text:
            (folder / name).write_text(text, encoding="utf-8")


def _contents() -> str:
    title = "The API by package"
    said = "A package imports only from those above it in this list, the order of the data flow."
    pages = [f"   {room}" for room in rooms()]
    return "\n".join([title, "=" * len(title), "", said, "", ".. toctree::", "   :maxdepth: 1", "", *pages, ""])


def of_others(app: Any, kind: str, name: str, thing: Any, skip: bool, options: Any) -> bool | None:
    """Leave out what others documented: methods inherited from libraries, bound methods of built-in types."""
    owner = getattr(thing, "__module__", "narrows")
    return True if inspect.isroutine(thing) and not str(owner).startswith("narrows") else None


def keep_constant(app: Any, kind: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    """Remember what is said of a constant before Napoleon takes what stands before a colon for its type."""
    if kind in ("data", "attribute", "property"):
        _SAID[name] = list(lines)


def restore_constant(app: Any, kind: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    """Say of a constant what its docstring says."""
    if name in _SAID:
        lines[:] = _SAID.pop(name)


def describe_numbers(app: Any, kind: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    """List the numbers of a section of a ship file, which describes them where it defines them."""
    if kind == "class" and issubclass(thing, Part) and thing is not Part:
        lines += ["", "Parameters", "----------"]
        for number, quantity in thing.numbers().items():
            lines += [f"{number} : float [{quantity.unit}]", f"    {quantity.meaning}"]


def rooms() -> list[str]:
    """The rooms from the first to the last, as the import contracts order them."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    layers = settings["tool"]["importlinter"]["contracts"][0]["layers"]
    return [room for layer in reversed(layers) for room in layer.split(" | ") if room != "__main__"]


def _page(room: str) -> str:
    title = f"narrows.{room}"
    return "\n".join(
        [title, "=" * len(title), "", *(part for name in _modules(title) for part in _module(name, title))]
    )


def _modules(title: str) -> list[str]:
    package = Path(narrows.__file__).parent / title.partition(".")[2]
    below = [info.name for info in pkgutil.walk_packages([str(package)], f"{title}.")] if package.is_dir() else []
    return [name for name in (title, *below) if name not in NOT_IMPORTED]


def _module(name: str, title: str) -> list[str]:
    heading = [name, "-" * len(name), ""] if name != title else []
    return [*heading, f".. automodule:: {name}", "   :ignore-module-all:", ""]
