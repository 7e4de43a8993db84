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
CHECKED = {
    "main_dimensions": {"sailed": False},
    "separation": {"sets": ("harmonic yaw, one run", "and straight runs off the centreline")},
    "helms": {"chosen": ("gust",)},
    "estimation": {"ways": ("considered",)},
    "sensor_errors": {"chosen": ("white, 1.5 m",)},
    "log_faults": {"chosen": ("a rudder half as large",)},
    "suez": {"intervals": ("as identified",)},
}
"""What of a table is made again where all of it takes minutes."""


def first_cell(line: str) -> str:
    """Return what a row of a table begins with; nothing for a line between tables."""
    return line.partition("|")[2].partition("|")[0]


@pytest.mark.parametrize(("script", "page"), PAGES.items())
@pytest.mark.slow
def test_the_docs_say_what_is_computed(script: str, page: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(ROOT / "decisions")
    for name in (script, "pages"):
        sys.modules.pop(name, None)
    made = importlib.import_module(script).text(**CHECKED.get(script, {}))
    kept = (ROOT / "docs" / page).read_text(encoding="utf-8")
    kept = kept.partition(f"<!-- made by decisions/{script}.py -->\n")[2].partition("\n<!-- end -->")[0]
    if script in CHECKED:
        starts = {first_cell(line) for line in made.splitlines()}
        kept = "\n".join(line for line in kept.splitlines() if first_cell(line) in starts)
    assert NUMBER.sub("#", kept) == NUMBER.sub("#", made)
    numbers = [np.array([float(n) for n in NUMBER.findall(text)]) for text in (kept, made)]
    np.testing.assert_allclose(numbers[0], numbers[1], rtol=0.02, atol=0.002)
