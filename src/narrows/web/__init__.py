"""What pages in a browser share: scripts and styles as text, served as they are or set into a page."""

import re
from importlib.resources import files

EXPORT = re.compile(r"^export (?=(?:async )?function|const|let|class)", re.MULTILINE)


def asset(name: str) -> str:
    """Return a script or a style as it is."""
    return files(__package__).joinpath(name).read_text(encoding="utf-8")


def without_exports(text: str) -> str:
    """Return a script as it stands in another one."""
    return EXPORT.sub("", text)
