"""A column in any unit, in brackets or as a suffix, says the same as one in SI."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import narrows as nw
from narrows.captive.columns import COLUMNS
from narrows.readers.cells import parse_header
from tables import short_twin, written

UNITS = {
    "t": {"s": 1.0, "ms": 1e-3, "min": 60.0},
    "x": {"m": 1.0, "mm": 1e-3, "km": 1e3, "ft": 0.3048},
    "y": {"m": 1.0, "mm": 1e-3, "cm": 1e-2},
    "psi": {"rad": 1.0, "deg": np.pi / 180, "°": np.pi / 180, "mrad": 1e-3},
    "u": {"m/s": 1.0, "kn": 1852 / 3600, "knot": 1852 / 3600, "km/h": 1 / 3.6, "mm/s": 1e-3, "mps": 1.0},
    "v": {"m/s": 1.0, "cm/s": 1e-2},
    "r": {"rad/s": 1.0, "deg/s": np.pi / 180, "°/s": np.pi / 180, "deg/min": np.pi / 10800},
    "udot": {"m/s2": 1.0, "m/s^2": 1.0, "m/s²": 1.0, "mm/s2": 1e-3},
    "vdot": {"m/s2": 1.0},
    "rdot": {"rad/s2": 1.0, "deg/s2": np.pi / 180, "degps2": np.pi / 180},
    "heave": {"m": 1.0, "mm": 1e-3},
    "X": {"N": 1.0, "kN": 1e3},
    "Y": {"N": 1.0, "kN": 1e3},
    "N": {"N m": 1.0, "Nm": 1.0, "kNm": 1e3, "Nmm": 1e-3, "kN m": 1e3},
}
CHOICES = st.fixed_dictionaries({name: st.sampled_from(sorted(units)) for name, units in UNITS.items()})
SUFFIXED = {
    "psi_deg": np.pi / 180, "r_degps": np.pi / 180, "rdot_degps2": np.pi / 180, "heave_mm": 1e-3, "u_mps": 1.0,
    "udot_mps2": 1.0, "x_mm": 1e-3, "Y_kN": 1e3, "N_Nm": 1.0, "t_s": 1.0, "r_radps": 1.0, "psi_rad": 1.0,
}  # fmt: skip


@pytest.mark.parametrize(("name", "unit"), [(name, unit) for name, units in UNITS.items() for unit in units])
def test_bracketed_unit(name: str, unit: str) -> None:
    column = parse_header(f"{name} [{unit}]", COLUMNS)
    assert column is not None
    assert (column.quantity, column.stated) == (name, True)
    assert column.scale == pytest.approx(UNITS[name][unit], rel=1e-12)


@pytest.mark.parametrize("header", SUFFIXED)
def test_suffixed_unit(header: str) -> None:
    column = parse_header(header, COLUMNS)
    assert column is not None
    assert (column.quantity, column.stated) == (header.split("_")[0], True)
    assert column.scale == pytest.approx(SUFFIXED[header], rel=1e-12)


@pytest.mark.parametrize("name", COLUMNS)
def test_bare_name_is_si(name: str) -> None:
    assert parse_header(f" {name} ", COLUMNS) == (f" {name} ", name, 1.0, False)


@pytest.mark.parametrize("header", ["comment", "rud_given", "psi_true", "u_mean", "Xrud_N", "test", "y2", "cos_psi"])
def test_other_headers_are_passed_over(header: str) -> None:
    assert parse_header(header, COLUMNS) is None


@given(units=CHOICES)
@settings(max_examples=8)
def test_table_in_any_units_reads_the_same(tmp_path_factory: pytest.TempPathFactory, units: dict[str, str]) -> None:
    short = short_twin()
    names = {name for name in short.columns if name in COLUMNS}
    frame = {f"{name} [{units[name]}]": short.columns[name] / UNITS[name][units[name]] for name in sorted(names)}
    test = np.repeat(short.names, np.diff(short.starts))
    path = written(pd.DataFrame({"test": test, **frame}), tmp_path_factory.mktemp("units") / "t.parquet")
    again = nw.read_captive(path, short.configuration)
    for name in names:
        np.testing.assert_allclose(again.columns[name], short.columns[name], rtol=1e-12, atol=1e-15)


def test_suffixes_and_brackets_mix(short: nw.CaptiveTests, table: pd.DataFrame, tmp_path: Path) -> None:
    spelled = table.assign(psi=np.degrees(table.psi), r=np.degrees(table.r), heave=table.heave * 1e3)
    spelled = spelled.rename(columns={"psi": "psi_deg", "r": "r [deg/s]", "heave": "heave_mm"})
    again = nw.read_captive(written(spelled, tmp_path / "t.csv"), short.configuration)
    for name in ("psi", "r", "heave", "cos_psi"):
        np.testing.assert_allclose(again.columns[name], short.columns[name], rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize(
    ("header", "scale"), [("revolutions [rpm]", 1 / 60), ("revolutions_rpm", 1 / 60), ("revolutions [rps]", 1)]
)
def test_a_revolution_is_one_turn(header: str, scale: float) -> None:
    column = parse_header(header, COLUMNS)
    assert column is not None
    assert column.scale == pytest.approx(scale)
