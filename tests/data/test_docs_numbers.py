"""The tables of the docs are what their scripts compute now from the measured tests."""

import importlib
import re
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parent.parent.parent
NUMBER = re.compile(r"-?\d+\.?\d*(?:e[+-]?\d+)?")
PAGES = {
    "bank_forms": "bank-forms.md",
    "term_tables": "uncertainty.md",
    "separation": "uncertainty.md",
    "kcs_left_out": "uncertainty.md",
    "squat": "squat.md",
    "shallow": "squat.md",
    "rudder": "rudder.md",
    "manoeuvres": "manoeuvres.md",
    "suez": "suez.md",
    "estimation": "benchmarks.md",
    "helms": "benchmarks.md",
    "sensor_errors": "benchmarks.md",
    "channel_rules": "safe-envelope.md",
    "log_faults": "benchmarks.md",
    "main_dimensions": "main-dimensions.md",
}
Rows = list[list[str]]
CHECKED = {
    "main_dimensions": {"sailed": False},
    "separation": {"sets": ("harmonic yaw, one run", "two amplitudes, and straight runs off the centreline")},
    "helms": {"chosen": ("gust",)},
    "estimation": {"ways": ("certain",)},
    "sensor_errors": {"chosen": ("white, 1.5 m",)},
    "log_faults": {"chosen": ("a rudder half as large",)},
    "suez": {"intervals": ("as identified",)},
}
"""What of a table is made again where all of it takes minutes."""


def numbers(rows: Rows) -> np.ndarray:
    """Return all numbers of rows."""
    return np.array([float(number) for row in rows for cell in row for number in NUMBER.findall(cell)])


SHOWN = [path.stem for path in sorted((ROOT / "decisions").glob("*.py")) if "\ndef shown(" in path.read_text("utf-8")]


@pytest.mark.parametrize("script", SHOWN)
def test_a_page_has_its_part_of_the_rows_that_are_kept(script: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(ROOT / "decisions")
    for name in (script, "pages"):
        sys.modules.pop(name, None)
    module, pages = (importlib.import_module(name) for name in (script, "pages"))
    mark = f"<!-- made by decisions/{script}.py -->\n"
    (text,) = (text for page in (ROOT / "docs").glob("*.md") if mark in (text := page.read_text(encoding="utf-8")))
    assert text.partition(mark)[2].partition("\n<!-- end -->")[0] == module.shown(pages.kept(script))


@pytest.mark.parametrize(("script", "page"), PAGES.items())
@pytest.mark.slow
def test_the_docs_say_what_is_computed(script: str, page: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(ROOT / "decisions")
    for name in (script, "pages"):
        sys.modules.pop(name, None)
    module, pages = (importlib.import_module(name) for name in (script, "pages"))
    block = (ROOT / "docs" / page).read_text(encoding="utf-8")
    block = block.partition(f"<!-- made by decisions/{script}.py -->\n")[2].partition("\n<!-- end -->")[0]
    kept = pages.kept(script) if script in SHOWN else pages.cells(block)
    made = pages.cells(module.text(**CHECKED.get(script, {})))
    if script in CHECKED:
        starts = {row[0] for row in made}
        kept = [row for row in kept if row[0] in starts]
    texts = [[[NUMBER.sub("#", cell) for cell in row] for row in rows] for rows in (kept, made)]
    assert texts[0] == texts[1]
    np.testing.assert_allclose(numbers(kept), numbers(made), rtol=0.02, atol=0.002)
