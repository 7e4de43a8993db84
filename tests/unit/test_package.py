"""The package as a house: one name for one thing, files and functions that fit a screen."""

import ast
from collections import Counter
from pathlib import Path

import narrows as nw

ROOT = Path(nw.__file__).parent
FILES = sorted(ROOT.rglob("*.py"))
AT_THE_ROOT = {"__main__", "__init__"}


def test_no_two_modules_have_one_stem() -> None:
    stems = Counter(path.stem for path in FILES if path.stem not in ("__init__", "settings"))
    assert [stem for stem, count in stems.items() if count > 1] == []


def test_no_two_public_classes_have_one_name() -> None:
    found = (node for path in FILES for node in ast.parse(path.read_text(encoding="utf-8")).body)
    names = Counter(node.name for node in found if isinstance(node, ast.ClassDef) and not node.name.startswith("_"))
    assert [name for name, count in names.items() if count > 1] == []


def test_few_modules_stand_at_the_root() -> None:
    assert {path.stem for path in ROOT.glob("*.py")} == AT_THE_ROOT


def test_no_file_is_longer_than_400_lines() -> None:
    assert {p.name: n for p in FILES if (n := len(p.read_text(encoding="utf-8").splitlines())) > 400} == {}
