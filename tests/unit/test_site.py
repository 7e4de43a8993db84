"""What the site makes of the package leaves nothing out, and what would ask the network is found."""

from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

import narrows as nw
from narrows.captive.columns import COLUMNS
from narrows.cli import app
from narrows.estimation.sensors import SENSORS
from narrows.export import EXPORTERS
from narrows.logbook.checking.check_log import RECORD_CHECKS
from narrows.logbook.checking.faults import FAULTS
from narrows.model.tables import BASES
from narrows.quantities.names import FORCES, MOTION, PARTICULARS
from narrows.safety.pilots import PILOTS

ROOT = Path(__file__).parents[2]


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    monkeypatch.syspath_prepend(ROOT / "docs")
    return import_module("_extension.makers").MAKERS


def said() -> Iterator[tuple[str, list[str]]]:
    """What a page is made of, and the names that must stand on it."""
    yield "motion", [f"`{name}`" for name in MOTION]
    yield "particulars", [f"`{name}`" for name in PARTICULARS]
    yield "forces", [f"`{name}`" for name in FORCES]
    yield "columns", [f"`{name}`" for name in COLUMNS]
    yield "term-tables", [f"`{name}`" for table in BASES.values() for name in table.names]
    yield "bank-forms", [f"`{name}`" for name in nw.FORMS]
    yield "squat-formulas", [f"`{name}`" for name in nw.SQUAT]
    yield "public-names", [f"`nw.{name}" for name in nw.__all__ if name != "__version__"]
    members = (*PILOTS, *SENSORS, *EXPORTERS, *FAULTS, *(own.__name__ for own in RECORD_CHECKS))
    yield "registries", [f"`{name}`" for name in members]
    yield "schemas", [f"## {path.stem}\n" for path in (ROOT / "src" / "narrows" / "schemas").glob("*.json")]


@pytest.mark.parametrize(("maker", "names"), list(said()), ids=lambda value: value if isinstance(value, str) else "")
def test_nothing_is_left_out(maker: str, names: list[str], made: dict[str, Any]) -> None:
    text = made[maker]()
    assert [name for name in names if name not in text] == []


@pytest.mark.slow
def test_every_verb_says_its_help(made: dict[str, Any]) -> None:
    text = made["commands"]()
    verbs = list(app.commands)
    assert [verb for verb in verbs if f"Usage: narrows {verb} " not in text] == []


def test_every_room_has_a_page(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.syspath_prepend(ROOT / "docs")
    rooms = import_module("_extension.rooms")
    (tmp_path / "reference" / "api").mkdir(parents=True)
    (tmp_path / "reference" / "api" / "gone.rst").write_text("gone")
    rooms.write_pages(tmp_path)
    pages = {path.stem for path in (tmp_path / "reference" / "api").glob("*.rst")}
    folders = {path.stem for path in (ROOT / "src" / "narrows").iterdir() if not path.name.startswith("_")}
    assert pages - {"index"} == folders - {"schemas", "py"}
    assert ".. automodule:: narrows.ship.particulars" in (tmp_path / "reference" / "api" / "ship.rst").read_text()


def test_a_build_replaces_older_files_to_take_along(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Also one that looks newer than the package, as after a step back in the history."""
    monkeypatch.syspath_prepend(ROOT / "docs")
    exports = import_module("_extension.exports")
    monkeypatch.setattr(exports, "FILES", {"dtc.h": exports.FILES["dtc.h"]})
    ready = tmp_path / exports.FOLDER / "dtc.h"
    ready.parent.mkdir(parents=True)
    ready.write_text("of another day")
    exports.write_all(tmp_path)
    nw.export.write(nw.published("mikkelsen2025_dtc"), tmp_path / "dtc.h")
    assert ready.read_bytes() == (tmp_path / "dtc.h").read_bytes()


@pytest.mark.parametrize(
    ("page", "asks"),
    [
        ('<script src="https://elsewhere.example/mathjax.js"></script>', True),
        ('<link rel="stylesheet" href="//elsewhere.example/a.css">', True),
        ('<img alt="" src="http://elsewhere.example/a.png">', True),
        ("@import url('https://elsewhere.example/font.css');", True),
        ('<script src="_static/mathjax.js"></script><img src="a.png">', False),
        ('<a href="https://elsewhere.example/">a link that is followed by choice</a>', False),
    ],
)
def test_what_asks_the_network_is_found(page: str, asks: bool, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.syspath_prepend(ROOT / "docs")
    (tmp_path / "page.html").write_text(page)
    assert bool(import_module("_extension.offline").asked_by(tmp_path / "page.html")) is asks


@pytest.mark.parametrize("name", ["from_above", "section"])
def test_the_axes_are_drawn_with_every_sign(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(ROOT / "docs")
    figure = getattr(import_module("_extension.axes"), name)()
    words = " ".join(text.get_text() for panel in figure.axes for text in panel.texts)
    signs = {
        "from_above": ("x", "y", r"\psi", "u", "v", "r", "X", "Y", "N", "y_s", "y_p", "W"),
        "section": ("h", "W", "B"),
    }
    assert [sign for sign in signs[name] if sign not in words] == []
