"""Pictures that pages show and nobody commits: made where they are absent or older than what they are made of."""

import os
import sys
from collections.abc import Callable
from pathlib import Path

from matplotlib.figure import Figure

import narrows
from _extension import axes

ROOT = Path(__file__).parents[2]
DECISIONS = ROOT / "decisions"


def from_decision(name: str) -> Callable[[], Figure]:
    """The figure of a script of `decisions`, which computes it."""

    def drawn() -> Figure:
        sys.path.insert(0, str(DECISIONS))
        try:
            return __import__(name).figure()
        finally:
            sys.path.remove(str(DECISIONS))

    return drawn


PICTURES: dict[str, Callable[[], Figure]] = {
    "axes-above.svg": axes.from_above,
    "axes-section.svg": axes.section,
    "bank-forms.svg": from_decision("bank_forms"),
    "control.png": from_decision("helms"),
    "suez.png": from_decision("suez"),
    "estimation.png": from_decision("estimation"),
    "steady.png": from_decision("steady"),
    "monitor.png": from_decision("monitor_page"),
}


def draw_all(source: Path, drawn: bool = True) -> None:
    """Draw what is not there yet, or older than the package and the scripts; or put blanks where nothing is."""
    folder = Path(source) / "pictures"
    folder.mkdir(exist_ok=True)
    if not drawn:
        for path in (folder / name for name in PICTURES if not (folder / name).exists()):
            Figure().savefig(path)
            os.utime(path, (0, 0))
        return
    newest = max(path.stat().st_mtime for path in _sources())
    for name, draw in PICTURES.items():
        path = folder / name
        if not path.exists() or path.stat().st_mtime < newest:
            draw().savefig(path, dpi=110)


def _sources() -> list[Path]:
    package = Path(narrows.__file__).parent
    return [path for folder in (package, DECISIONS, Path(__file__).parent) for path in folder.rglob("*.py")]
