"""The site asks nothing of the network: every script, style, font and picture is its own."""

import re
import shutil
from importlib.util import find_spec
from pathlib import Path
from typing import Any

ASKED = re.compile(
    r"""<(?:script|img|iframe|source|video|audio)\b[^>]*\bsrc=["'](?:https?:)?//[^"']+"""
    r"""|<link\b(?![^>]*\brel=["']canonical)[^>]*\bhref=["'](?:https?:)?//[^"']+"""
    r"""|@import\s+(?:url\()?["']?(?:https?:)?//[^"')]+|url\(["']?(?:https?:)?//[^"')]+"""
)


MATHJAX = "mathjax.js"
"""Draws formulas as SVG: one file, fonts included."""


def bring_mathjax(app: Any) -> None:
    """Take the script that draws formulas from the package that has it (which would copy all 24 MB of MathJax)."""
    found = find_spec("sphinx-mathjax-offline")
    if found is None or found.origin is None:
        raise RuntimeError("MathJax is absent; install the group docs")
    target = Path(app.outdir) / "_static" / MATHJAX
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(Path(found.origin).parent / "static" / "mathjax" / "tex-svg-full.js", target)


def check(app: Any, exception: Exception | None) -> None:
    """Refuse a site with a page or a style that fetches something from elsewhere."""
    if exception or app.builder.format != "html":
        return
    found = [
        f"{path.relative_to(app.outdir)}: {asked}" for path in _files(Path(app.outdir)) for asked in asked_by(path)
    ]
    if found:
        raise RuntimeError("the site would ask the network for\n" + "\n".join(found[:20]))


def asked_by(path: Path) -> list[str]:
    """What a file would fetch from elsewhere."""
    return [match[0][:200] for match in ASKED.finditer(path.read_text(encoding="utf-8", errors="replace"))]


def _files(folder: Path) -> list[Path]:
    return [path for suffix in ("*.html", "*.css") for path in sorted(folder.rglob(suffix))]
