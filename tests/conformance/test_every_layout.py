"""Every layout of ``captive/columns.py``: its sample is its own and no other's, and becomes tests in SI."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import narrows as nw
from narrows.captive import measured
from narrows.captive.columns import COLUMNS, LAYOUTS, Dtc, Layout, translated
from narrows.quantities.names import PARTICULARS
from narrows.ship.actuators import STANDARD
from tables import frame_of

MEASURED = Path(measured.__file__).parent
still = np.zeros(400)
DTC = (np.arange(1, 401) / 20.0, np.arange(1, 401) / 50.0, still, still, 2.0 + still, -30.0 + still, still, still)
SAMPLES = {
    "Dtc": pd.DataFrame(dict(zip(Dtc.HEADERS, DTC, strict=True))),  # 20 s of a steady speed along the tank
    "Fhr": pd.read_csv(MEASURED / "kcs_pmm_shallow.csv").groupby("type").head(1),
    "Lataire": pd.read_csv(MEASURED / "lataire2009.csv").groupby("bank name").head(1),
}
every_layout = pytest.mark.parametrize("layout", LAYOUTS, ids=lambda own: own.__name__)


@every_layout
def test_its_sample_is_recognised_by_it_and_by_no_other(layout: type[Layout]) -> None:
    assert [own.__name__ for own in LAYOUTS if own.recognises(SAMPLES[layout.__name__])] == [layout.__name__]


@every_layout
def test_it_leaves_the_documented_columns_alone(layout: type[Layout], short: nw.CaptiveTests) -> None:
    assert not layout.recognises(frame_of(short))
    assert not layout.recognises(pd.DataFrame())


@every_layout
def test_its_sample_becomes_tests(layout: type[Layout], ship_file: Path, tmp_path: Path) -> None:
    """Read from a file as any table is: finite numbers in SI, every force measured, and a word on what was done."""
    SAMPLES[layout.__name__].to_csv(tmp_path / "sample.csv", index=False)
    tests = nw.read_captive(tmp_path / "sample.csv", ship_file)
    assert tests.rows > 0
    known = {"cos_psi", "sin_psi", *COLUMNS, *PARTICULARS, *(name for own in STANDARD for name in own.controls)}
    assert {"u", "v", "r", "X", "Y", "N"} <= set(tests.columns) <= known
    assert all(np.isfinite(column).all() for column in tests.columns.values())
    assert tests.notes


@every_layout
def test_translating_changes_no_table(layout: type[Layout]) -> None:
    """What was measured stays as it was, and a second reading is the first."""
    frame = SAMPLES[layout.__name__].copy()
    once, said = translated(frame, "", "table")
    pd.testing.assert_frame_equal(frame, SAMPLES[layout.__name__])
    again, said_again = layout.translated(frame, "", "table")
    pd.testing.assert_frame_equal(once, again)
    assert said == said_again


@every_layout
def test_it_says_whose_tables_they_are(layout: type[Layout]) -> None:
    assert (layout.__doc__ or "").partition("\n")[0].endswith(".")
