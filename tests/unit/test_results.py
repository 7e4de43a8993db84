"""Every result can do the same: say what was found, give it by name, as a table, and show itself in one short line."""

import json
from functools import cache

import numpy as np
import pandas as pd
import pytest

import narrows as nw
from narrows.experiment_design import plan_tests
from narrows.results import Result, to_json
from tables import short_twin

DTC = nw.published("mikkelsen2025_dtc")
DEEP = nw.Configuration(nw.Ship(230.0, 32.2, 10.8, 0.65), nw.Canal(300.0, 16.2))


@cache
def result(kind: str) -> Result:
    """One of each."""
    if kind == "Fit":
        return nw.identify(short_twin())
    if kind == "Comparison":
        return nw.compare(short_twin(), ("paper", "speed", "paper+distance_depth"))
    if kind == "Explanation":
        return nw.explain(DTC, short_twin(), ("speed",))
    if kind == "Plan":
        return plan_tests(DTC.configuration, 2)
    if kind == "Scaled":
        return nw.scale_model(DTC, 355.0)
    if kind == "DepthCorrected":
        return nw.at_depth(DTC, 0.3)
    if kind == "Squat":
        return nw.squat(DEEP, 4.0, "bow")
    return nw.sail_trials(nw.published("yasukawa2015_kvlcc2"), 1.179, zigzags=())


KINDS = ("Fit", "Comparison", "Explanation", "Plan", "Scaled", "DepthCorrected", "Squat", "Trials")


@pytest.mark.parametrize("kind", KINDS)
def test_results_speak_alike(kind: str) -> None:
    found = result(kind)
    assert isinstance(found, Result)
    assert type(found).__name__ == kind
    assert len(found.summary().splitlines()) == len(list(filter(None, found.summary().split("\n")))) > 0
    assert all(isinstance(note, str) and note for note in found.notes)
    assert isinstance(found.notes, tuple)
    assert json.loads(to_json(found.to_dict()))["notes"] == list(found.notes)
    assert len(repr(found).splitlines()) == 1
    assert len(repr(found)) < 200


@pytest.mark.parametrize(("kind", "rows"), [("Fit", 17), ("Comparison", 6), ("Plan", 2), ("Scaled", 17)])
def test_what_makes_a_table_gives_it(kind: str, rows: int) -> None:
    frame = result(kind).to_dataframe()  # type: ignore[attr-defined]
    assert isinstance(frame, pd.DataFrame)
    assert len(frame) == rows


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
