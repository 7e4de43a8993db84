"""Shared scripts and styles of browser pages, as text."""

import re
from importlib.resources import files

EXPORT = re.compile(r"^export (?=(?:async )?function|const|let|class)", re.MULTILINE)


def asset(name: str) -> str:
    """Return a script or a style unchanged."""
    return files(__package__).joinpath(name).read_text(encoding="utf-8")


def without_exports(text: str) -> str:
    """Return a script for inclusion in another one."""
    return EXPORT.sub("", text)
