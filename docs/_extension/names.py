"""The names of the package itself, by the room that each comes from."""

import ast
import inspect
from pathlib import Path
from typing import Any

import narrows
from _extension.markdown import table
from _extension.rooms import rooms


def text() -> str:
    """Write a table a room: name and the first line of what it says of itself."""
    found = _by_room()
    parts = [
        f"## {room}\n\n{table(('name', 'what it is'), map(_row, found[room]))}" for room in rooms() if room in found
    ]
    return "\n\n".join(parts)


def _by_room() -> dict[str, list[tuple[str, str]]]:
    """Each name with its module, by room."""
    tree = ast.parse(Path(narrows.__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    found: dict[str, list[tuple[str, str]]] = {}
    for statement in tree.body:
        if isinstance(statement, ast.ImportFrom) and statement.module:
            room = statement.module.partition(".")[0]
            found.setdefault(room, []).extend((name.name, f"narrows.{statement.module}") for name in statement.names)
    return found


def _row(named: tuple[str, str]) -> tuple[str, str]:
    name, module = named
    thing = getattr(narrows, name)
    if not (inspect.isclass(thing) or inspect.isfunction(thing)):
        return f"`nw.{name}`", _constant(thing, module)
    line = (inspect.getdoc(thing) or "").partition("\n")[0]
    return f"{{py:obj}}`nw.{name} <{thing.__module__}.{thing.__qualname__}>`", line.replace("``", "`")


def _constant(thing: Any, module: str) -> str:
    return f"{type(thing).__name__} of `{module}`"
