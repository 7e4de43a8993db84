"""The names of the package itself, by the room that each comes from."""

import ast
import inspect
from operator import attrgetter
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
        elif isinstance(statement, ast.ImportFrom):
            for name in statement.names:
                found.setdefault(name.name, []).extend(_of_room(name.name))
    return found


def _of_room(room: str) -> list[tuple[str, str]]:
    """A room that is itself a name, and what it has beyond the names of the package."""
    own = vars(getattr(narrows, room))
    names = [n for n, it in own.items() if not n.startswith("_") and (inspect.isclass(it) or inspect.isfunction(it))]
    return [
        (room, "narrows"),
        *((f"{room}.{name}", f"narrows.{room}") for name in names if name not in narrows.__all__),
    ]


def _row(named: tuple[str, str]) -> tuple[str, str]:
    name, module = named
    thing = attrgetter(name)(narrows)
    if inspect.ismodule(thing):
        return f"{{py:obj}}`nw.{name} <{thing.__name__}>`", (inspect.getdoc(thing) or "").partition("\n")[0]
    if not (inspect.isclass(thing) or inspect.isfunction(thing)):
        return f"`nw.{name}`", _constant(thing, module)
    line = (inspect.getdoc(thing) or "").partition("\n")[0]
    return f"{{py:obj}}`nw.{name} <{thing.__module__}.{thing.__qualname__}>`", line.replace("``", "`")


def _constant(thing: Any, module: str) -> str:
    return f"{type(thing).__name__} of `{module}`"
