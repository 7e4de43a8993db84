"""Every layout of ``captive/layouts.py``: its sample is its own and no other's, and becomes tests in SI."""

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
import pytest

import narrows as nw
from narrows.captive import layouts, measured
from narrows.captive.columns import COLUMNS
from narrows.captive.layouts import LAYOUTS, Dtc, Layout, translated
from narrows.quantities.names import PARTICULARS
from narrows.ship.actuators import STANDARD
from tables import frame_of

MEASURED = Path(measured.__file__).parent
T, ONES = np.arange(1, 401) / 20, np.ones(400)
DTC = (T, 0.4 * T, 0.1 * T, 2 + T, 2 * ONES, -30 * ONES, 4 * ONES, -5 * ONES)

TURNED = math.radians(2.05)  # Heading of the first row


class Sample(NamedTuple):
    """A table of the layout, and what its first row is in SI, converted by hand from what is printed there."""

    frame: pd.DataFrame
    first: dict[str, float]


SAMPLES = {
    # 20 s of a steady speed along and across the tank, turning by 1 degree a second
    "Dtc": Sample(
        pd.DataFrame(dict(zip(Dtc.HEADERS, DTC, strict=True))),
        {"u": 0.4 * math.cos(TURNED) + 0.1 * math.sin(TURNED), "v": 0.1 * math.cos(TURNED) - 0.4 * math.sin(TURNED),
         "r": math.pi / 180, "sin_psi": math.sin(TURNED), "X": -30.0, "Y": 4.0, "N": -5.0, "heave": 0.002},
    ),
    # The last type, harmonic yaw, first
    "Fhr": Sample(
        pd.read_csv(MEASURED / "kcs_pmm_shallow.csv").groupby("type").head(1).iloc[::-1],
        {"y": -0.0006, "sin_psi": -math.sin(math.pi / 12), "u": 0.248, "v": 0.0, "r": 0.0035 * math.pi / 180,
         "rdot": 0.3491 * math.pi / 180, "X": -0.5042, "Y": -0.1645, "N": -5.7464, "heave": 0.0003652,
         "revolutions": 110.2924 / 60},
    ),
    # Bank V rises by 1/8 from 0.53 m: 0.36 m deep it ends at 3.41 m, as large as a wall at 0.53 + 2.88 / 2 = 1.97 m.
    "Lataire": Sample(
        pd.read_csv(MEASURED / "lataire2009.csv").groupby("bank name").head(1),
        {"y": 0.265 + (3.5 - 1.97) / 2, "width": 3.5 + 1.97, "depth": 0.36, "sin_psi": math.sin(math.pi / 36),
         "u": 0.6842, "v": -0.0599, "r": 0.0, "X": -4.13, "Y": 5.139, "N": 8.939, "heave": 0.00437, "revolutions": 0.0},
    ),
}  # fmt: skip
every_layout = pytest.mark.parametrize("layout", LAYOUTS, ids=lambda own: own.__name__)


def test_no_layout_is_forgotten() -> None:
    own = (one for one in vars(layouts).values() if isinstance(one, type) and hasattr(one, "translated"))
    assert {*own} - {Layout} == {*LAYOUTS}
    assert SAMPLES.keys() == {layout.__name__ for layout in LAYOUTS}, "give each a sample"


@every_layout
def test_its_sample_is_recognised_by_it_and_by_no_other(layout: type[Layout]) -> None:
    assert [own.__name__ for own in LAYOUTS if own.recognises(SAMPLES[layout.__name__].frame)] == [layout.__name__]


@every_layout
def test_it_leaves_the_documented_columns_alone(layout: type[Layout], short: nw.CaptiveTests) -> None:
    assert not layout.recognises(frame_of(short))
    assert not layout.recognises(pd.DataFrame())


@every_layout
def test_its_sample_becomes_tests(layout: type[Layout], ship_file: Path, tmp_path: Path) -> None:
    """Read from a file as any table is: finite numbers in SI, every force measured, and a word on what was done."""
    sample = SAMPLES[layout.__name__]
    sample.frame.to_csv(tmp_path / "sample.csv", index=False)
    tests = nw.read_captive(tmp_path / "sample.csv", ship_file)
    assert tests.rows > 0
    known = {"cos_psi", "sin_psi", *COLUMNS, *PARTICULARS, *(name for own in STANDARD for name in own.controls)}
    assert {"u", "v", "r", "X", "Y", "N"} <= set(tests.columns) <= known
    assert all(np.isfinite(column).all() for column in tests.columns.values())
    assert tests.notes
    assert {"u", "v", "r", "X", "Y", "N"} <= sample.first.keys()
    for name, value in sample.first.items():
        assert tests.columns[name][0] == pytest.approx(value, rel=1e-3, abs=1e-9), name


@every_layout
def test_translating_changes_no_table(layout: type[Layout]) -> None:
    """What was measured stays as it was, and a second reading is the first."""
    frame = SAMPLES[layout.__name__].frame.copy()
    once, said = translated(frame, "", "table")
    pd.testing.assert_frame_equal(frame, SAMPLES[layout.__name__].frame)
    again, said_again = layout.translated(frame, "", "table")
    pd.testing.assert_frame_equal(once, again)
    assert said == said_again


@every_layout
def test_it_says_whose_tables_they_are(layout: type[Layout]) -> None:
    assert (layout.__doc__ or "").partition("\n")[0].endswith(".")
