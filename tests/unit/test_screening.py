"""One wrong cell among hundreds does not change a coefficient, and is named by row and column."""

import numpy as np
import pandas as pd
import pytest

import narrows as nw
from narrows.base.errors import InputError
from narrows.captive.measured import measured_files

HULL = {"length": 7.0, "beam": 1.0, "draft": 0.33, "block_coefficient": 0.65}
SHIP = {"ship": HULL, "canal": {"width": 7.0, "depth": 0.5}}
ROWS = 200


def table() -> pd.DataFrame:
    """Three runs of a ship that sways, in SI, in time and kinematics of one motion."""
    t = np.tile(np.linspace(0, 20, ROWS), 3)
    omega, size = 0.6, np.repeat([0.1, 0.2, 0.3], ROWS)
    y, v, vdot = size * np.sin(omega * t), omega * size * np.cos(omega * t), -(omega**2) * size * np.sin(omega * t)
    still = np.zeros_like(t)
    columns = {"t": t, "y": y, "psi": still, "u": still + 0.8, "v": v, "r": still, "udot": still, "vdot": vdot,
               "rdot": still, "heave": still, "X": still - 5.0, "Y": -700 * vdot - 40 * v, "N": 20 * v}  # fmt: skip
    return pd.DataFrame({"test": np.repeat(["a", "b", "c"], ROWS), **columns})


@pytest.mark.parametrize("column", ["Y", "v", "u", "r", "X", "y"])
@pytest.mark.parametrize("mark", [9999.0, -999.0, 1e10, 9.97e36, np.inf])
def test_one_mark_of_a_missing_value_is_left_out_by_row(column: str, mark: float) -> None:
    spoiled = table()
    spoiled.loc[250, column] = mark
    tests = nw.read_captive(spoiled, SHIP)
    assert len(tests.columns["Y"]) == 3 * ROWS - 1
    assert any("row 250" in note and repr(column) in note for note in tests.notes)


def test_a_spike_of_any_size_is_left_out() -> None:
    spoiled = table()
    spoiled.loc[7, "N"] = 4321.0
    assert len(nw.read_captive(spoiled, SHIP).columns["Y"]) == 3 * ROWS - 1


def test_a_clean_table_keeps_every_row() -> None:
    """A step, a ramp and noise are measurements."""
    clean = table()
    clean["X"] += np.where(clean.index > 100, -15.0, 0.0) + np.random.default_rng(1).normal(0, 1, len(clean))
    assert len(nw.read_captive(clean, SHIP).columns["Y"]) == 3 * ROWS


def test_measured_tests_keep_every_row() -> None:
    path, ship = measured_files("kcs")
    assert not any("left out" in note for note in nw.read_captive(path, ship).notes)


def test_measured_static_runs_of_a_row_each_are_kept() -> None:
    (path, ship), query = measured_files("kcs"), "type == 'STATX0' and abs(psi_deg) < 80"
    assert nw.read_captive(path, ship, query).rows == len(pd.read_csv(path).query(query))


def static_table(rows: int, largest: float, marked: int) -> pd.DataFrame:
    """Tests of a row each whose side force is as large as a marker, of which some rows hold one."""
    y, u = np.tile([-1.5, -1.0, -0.5, 0.5, 1.0, 1.5], rows)[:rows], np.where(np.arange(rows) % 4, 0.6, 1.0)
    side = largest * y / 1.5 * u**2 + np.random.default_rng(0).normal(0, 0.3, rows)
    side[1 : 1 + marked] = -999.0
    still = dict.fromkeys(("psi", "v", "r", "udot", "vdot", "rdot", "heave"), 0.0)
    columns = {"test": [f"t{i}" for i in range(rows)], "y": y, "u": u, "X": -5 * u**2, "Y": side, "N": -0.3 * side}
    return pd.DataFrame({**columns, **still})


def test_a_marker_in_three_rows_is_found_among_forces_of_its_size() -> None:
    tests = nw.read_captive(static_table(100, 900.0, 3), SHIP)
    assert tests.rows == 97
    assert any("row 1, column 'Y' holds -999, and 2 more" in note for note in tests.notes)
    with pytest.raises(InputError, match=r"row 1, column .Y. holds -999, as do 2 more rows"):
        nw.read_captive(static_table(7, 50.0, 3), SHIP)


def test_a_value_that_is_set_is_no_marker() -> None:
    table = static_table(100, 50.0, 0).assign(n_rpm=np.where(np.arange(100) < 60, 999.0, 700.0))
    assert nw.read_captive(table, SHIP).rows == 100


def test_a_run_of_markers_alone_is_found() -> None:
    spoiled = table()
    spoiled.loc[ROWS : 2 * ROWS - 1, "N"] = -999.0
    with pytest.raises(InputError, match=r"row 200, column .N. holds -999, as do 199 more rows"):
        nw.read_captive(spoiled, SHIP)


def test_a_column_with_many_wrong_rows_is_refused() -> None:
    spoiled = table()
    spoiled.loc[::10, "Y"] = -999.0
    with pytest.raises(InputError, match=r"row 0, column .Y. holds -999, as do 59 more rows"):
        nw.read_captive(spoiled, SHIP)
