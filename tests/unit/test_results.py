"""Every result can do the same: say what was found, give it by name, as a table, and show itself in one short line."""

import json
from functools import cache
from html import escape
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from matplotlib.figure import Figure

import narrows as nw
from narrows.base.files import to_json
from narrows.base.results import BaseResult
from narrows.identification.fitting import bundled_ship
from narrows.identification.plan import plan_tests
from narrows.model.tables import table_named
from narrows.studies.mikkelsen2025 import reproduce
from tables import short_twin

DTC = nw.published("mikkelsen2025_dtc")
DEEP = nw.Configuration(nw.Ship(230.0, 32.2, 10.8, 0.65), nw.Canal(300.0, 16.2))


def steered_kcs() -> nw.Model:
    """A fit that is kept for other tests."""
    return bundled_ship(230.0, 300.0, 16.2, table_named("speed+helm"))


@cache
def result(kind: str) -> BaseResult:
    """One of each."""
    if kind == "Fit":
        return nw.identify(short_twin())
    if kind == "Comparison":
        return nw.compare(short_twin(), ("paper", "speed", "paper+distance_depth"))
    if kind == "Explanation":
        return nw.explain(DTC, short_twin(), ("speed",))
    if kind == "Plan":
        return plan_tests(DTC.configuration, 2, tank=nw.Tank(run_length=20.0, speeds=(0.7,)))
    if kind == "Scaled":
        return nw.scale_model(DTC, 355.0)
    if kind == "DepthCorrected":
        return nw.at_depth(DTC, 0.3)
    if kind == "Squat":
        return nw.squat(DEEP, 4.0, "bow")
    if kind == "Voyage":
        return nw.simulate(DTC, 0.5)
    if kind == "OutsideRules":
        return nw.outside_rules(DEEP)
    if kind == "SafeEnvelope":
        shaped = nw.borrow_rudder(DTC, steered_kcs())
        return nw.safe_envelope(shaped, np.array([0.0, 0.2]), np.array([0.5, 0.6]), samples=4)
    if kind == "Reproduction":
        return reproduce()
    return nw.sail_trials(nw.published("yasukawa2015_kvlcc2"), 1.179, zigzags=((10, 10),))


ROWS = {
    "Fit": 17, "Comparison": 6, "Explanation": 17, "Plan": 2, "Scaled": 17, "DepthCorrected": 17, "Squat": 1,
    "Voyage": None, "OutsideRules": 9, "SafeEnvelope": 2, "Reproduction": 17, "Trials": None,
}  # fmt: skip
"""Of the table of each kind of result, where it is always as long."""


@pytest.mark.parametrize("kind", ROWS)
def test_results_speak_alike(kind: str) -> None:
    found = result(kind)
    assert isinstance(found, BaseResult)
    assert type(found).__name__ == kind
    lines = found.summary().partition("\n\n")[0].split("\n")  # A table follows an empty line
    assert lines == list(filter(None, lines)) != []
    assert all(isinstance(note, str) and note for note in found.notes)
    assert isinstance(found.notes, tuple)
    assert json.loads(to_json(found.to_dict()))["notes"] == list(found.notes)
    assert len(repr(found).splitlines()) == 1
    assert len(repr(found)) < 200
    page = found._repr_html_()
    assert escape(found.summary().splitlines()[0]) in page
    assert all(escape(note) in page for note in found.notes)


@pytest.mark.parametrize("kind", ROWS)
def test_results_draw_themselves_and_go_into_files(kind: str, tmp_path: Path) -> None:
    found = result(kind)
    drawn = found.plot()
    assert isinstance(drawn, Figure)
    assert drawn._repr_png_().startswith(b"\x89PNG")  # What a notebook shows, pyplot loaded or not.
    assert found.plot().axes[0].has_data()
    frame = found.to_dataframe()  # type: ignore[attr-defined]
    assert isinstance(frame, pd.DataFrame)
    assert len(frame) == ROWS[kind] or (ROWS[kind] is None and len(frame) > 9)
    for name in ("a.json", "a.svg", "a.csv"):
        found.save(tmp_path / name)
    saved = json.loads((tmp_path / "a.json").read_text())
    data = saved.pop("data", {"variables": {}})
    assert saved == json.loads(to_json(found.to_dict()))
    assert set(data["variables"]) == set(found.dataset().data_vars if hasattr(found, "dataset") else ())
    assert len(pd.read_csv(tmp_path / "a.csv")) == len(frame)
    assert "<svg" in (tmp_path / "a.svg").read_text()
    if hasattr(found, "dataset"):
        found.save(tmp_path / "a.nc")
        with xr.open_dataset(tmp_path / "a.nc", engine="scipy") as again:
            assert again.sizes == found.dataset().sizes
    with pytest.raises(nw.InputError, match=r"a\.doc: cannot write a doc file here; name it .*\.json, .*\.png"):
        found.save(tmp_path / "a.doc")


def test_a_model_saves_itself_and_is_short_to_read(tmp_path: Path) -> None:
    DTC.save(tmp_path / "dtc.toml")
    assert nw.load_model(tmp_path / "dtc.toml").coefficients == DTC.coefficients
    assert repr(DTC) == f"<Model of {DTC.configuration.ship.name}: 17 coefficients of the terms paper>"


def test_the_table_of_a_fit_is_the_fit() -> None:
    fit = nw.identify(short_twin())
    frame = fit.to_dataframe()
    assert frame["value"].to_dict() == fit.coefficients
    np.testing.assert_array_equal(frame["std"], list(fit.std.values()))
    assert [tuple(row) for row in frame[["low", "high"]].to_numpy().tolist()] == list(fit.intervals.values())
    assert frame["verdict"].to_dict() == {name: own.status for name, own in fit.verdicts.items()}
    assert f"RMSE {fit.scores['Y'].rmse:.3g}" in fit.summary()


def test_one_rule_of_what_the_data_covered() -> None:
    known = nw.DataRange(speed=(0.5, 1.0), abs_y=(0.0, 2.0))
    speeds = np.array([0.48, 0.495, 0.7, 1.0, 1.005, 1.02, np.nan])
    assert known.outside("speed", speeds).tolist() == [True, False, False, False, False, True, False]
    assert not known.outside("abs_y", 2.01)
    assert known.outside("abs_y", 2.03)
    assert not known.outside("abs_psi", 1e9)
