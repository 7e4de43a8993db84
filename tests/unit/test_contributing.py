"""The map of the house is true: every room stands in it, and every file it names is there."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "contributing.md").read_text(encoding="utf-8")
PACKAGE = ROOT / "src" / "narrows"
ROOMS = re.findall(r"^\| `([a-z_]+)` \|", PAGE, re.MULTILINE)
NAMED = re.findall(r"`((?:[\w.]+/)+[\w.]*)`", PAGE)
PLACES = (ROOT, PACKAGE, PACKAGE / "identification")
"""Where paths on the page begin: at the repository, in the package, or in the room that is spoken of."""


def test_every_room_is_on_the_map_and_no_other() -> None:
    assert sorted(ROOMS) == sorted(path.parent.name for path in PACKAGE.glob("*/__init__.py"))


def test_every_file_that_is_named_is_there() -> None:
    inside = (*PLACES, *(PACKAGE / room for room in ROOMS))
    assert len(NAMED) > 30
    assert [path for path in NAMED if not any((place / path).exists() for place in inside)] == []


def test_the_rooms_stand_in_the_order_that_their_imports_keep() -> None:
    """A room imports from rooms above it in the list, none below."""
    for place, room in enumerate(ROOMS):
        text = "\n".join(path.read_text(encoding="utf-8") for path in (PACKAGE / room).rglob("*.py"))
        below = set(re.findall(r"^\s*from narrows\.(\w+)", text, re.MULTILINE)) & set(ROOMS[place + 1 :])
        assert not below, f"{room} imports {below}"
