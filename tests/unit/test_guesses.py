"""Sixty guesses of a user of pandas, xarray, scikit-learn, statsmodels, SciPy and python-control, written down before
the names of the package were looked at. Those that do not hold are listed with why."""

import pickle
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from scipy.integrate import solve_ivp

import narrows as nw
from tables import DTC_SHIP, frame_of, short_twin

DTC = nw.published("mikkelsen2025_dtc")
STEERED = nw.published("yasukawa2015_kvlcc2")


@cache
def fit() -> nw.Fit:
    return nw.identify(short_twin())


@cache
def voyage() -> nw.Voyage:
    return nw.simulate(DTC, 0.5)


@cache
def fleet() -> xr.Dataset:
    return nw.ensemble(DTC, y=0.5, duration=2.0, samples=0, b_bank=xr.DataArray([1.0, 1.1], dims="sample"))


def saved(folder: Path) -> Path:
    DTC.save(folder / "dtc.toml")
    return folder / "dtc.toml"


def written(folder: Path, thing: Any) -> int:
    thing.to_csv(folder / "a.csv")
    return len(pd.read_csv(folder / "a.csv"))


def sailed() -> Any:
    start = [0.0, 0.5, 0.0, 1.0, 0.0, 0.0]
    return solve_ivp(lambda t, x: DTC.derivative(x), (0.0, 1.0), start, rtol=1e-9, atol=1e-9).y[:, -1]


def ship_file(folder: Path) -> Path:
    (folder / "ship.toml").write_text(DTC_SHIP)
    return folder / "ship.toml"


TESTS = short_twin
GUESSES: dict[str, Callable[[Path], Any]] = {
    "tests.columns": lambda at: "y" in TESTS().columns,
    'tests["y"]': lambda at: TESTS()["y"].shape == (TESTS().rows,),
    "tests.shape": lambda at: TESTS().shape[0] == TESTS().rows,
    "tests.head()": lambda at: len(TESTS().head()) == 5,
    "tests.describe()": lambda at: "mean" in TESTS().describe().index,
    'tests.query("y > 0")': lambda at: 0 < TESTS().query("y > 0").rows < TESTS().rows,
    "tests[mask]": lambda at: (TESTS()[TESTS()["y"] > 0]["y"] > 0).all(),
    '"y" in tests': lambda at: "y" in TESTS() and "height" not in TESTS(),
    "tests.to_csv(path)": lambda at: written(at, TESTS()) == TESTS().rows,
    'tests.units["Y"]': lambda at: TESTS().units["Y"] == "N",
    "tests.ship": lambda at: TESTS().ship.length == 3.984,
    "nw.concat([tests, tests])": lambda at: len(nw.concat([TESTS(), TESTS()])) == 8,
    'tests.save("t.parquet")': lambda at: (
        TESTS().save(at / "t.parquet") or len(pd.read_parquet(at / "t.parquet")) == 445
    ),
    "tests.to_xarray()": lambda at: "Y" in TESTS().to_xarray(),
    'fit.coefficients["b_v"]': lambda at: fit().coefficients["b_v"] > 0,
    "fit.params": lambda at: fit().params,
    "fit.conf_int()": lambda at: fit().conf_int().shape == (17, 2),
    'fit.rsquared["Y"]': lambda at: 0.9 < fit().rsquared["Y"] <= 1,
    "fit.score(tests)": lambda at: fit().score(TESTS())["Y"].r2 == pytest.approx(fit().rsquared["Y"]),
    'fit.rmse["Y"]': lambda at: fit().rmse["Y"] == pytest.approx(fit().residuals["Y"].pow(2).mean() ** 0.5, rel=0.01),
    "fit.covariance": lambda at: fit().covariance.shape == (17, 17),
    "fit.standard_errors": lambda at: fit().standard_errors,
    "fit.nobs": lambda at: fit().nobs == TESTS().rows,
    "fit.predict(df)": lambda at: np.allclose(fit().predict(frame_of(TESTS())), fit().predict()),
    "fit.fittedvalues": lambda at: fit().fittedvalues,
    "fit.to_csv(path)": lambda at: written(at, fit()) == 17,
    "fit.tests": lambda at: len(fit().tests) == 4,
    "pickle a fit": lambda at: pickle.loads(pickle.dumps(fit())).coefficients == fit().coefficients,
    "fit.plot().savefig(path)": lambda at: fit().plot().savefig(at / "a.png") or (at / "a.png").stat().st_size > 0,
    'fit.intervals["b_v"]': lambda at: fit().intervals["b_v"][0] < fit().intervals["b_v"][1],
    'model["b_v"]': lambda at: DTC["b_v"] == DTC.coefficients["b_v"],
    "model.coefficients.items()": lambda at: len(DTC.coefficients.items()) == 17,
    "model.replace(b_v=1)": lambda at: DTC.replace(b_v=1.0),  # type: ignore[attr-defined]
    "nw.Model.load(path)": lambda at: nw.Model.load(saved(at)).coefficients == DTC.coefficients,
    "nw.Model.from_dict(model.to_dict())": lambda at: nw.Model.from_dict(DTC.to_dict()) == DTC,
    "model == loaded": lambda at: nw.load_model(saved(at)) == DTC and DTC.with_coefficients(b_v=1.0) != DTC,
    "pickle a model": lambda at: pickle.loads(pickle.dumps(DTC)) == DTC,
    "model.simulate(y=0.5)": lambda at: DTC.simulate(y=0.5).outcome == voyage().outcome,
    "model.linearize(y=0.5)": lambda at: DTC.linearize(y=0.5).A.shape == (6, 6),
    "model.scale(length=355)": lambda at: DTC.scale(length=355.0).model.ship.length == 355.0,
    "solve_ivp(model.derivative)": lambda at: np.allclose(sailed()[:2], [voyage().x[50], voyage().y[50]], atol=1e-7),
    "model.forces(y=[...], u=1)": lambda at: DTC.forces(y=np.array([0.0, 0.5]), u=1.0)["Y"].shape == (2,),
    "model.ship.L": lambda at: DTC.ship.L,  # type: ignore[attr-defined]
    "model.terms.names": lambda at: "b_v" in DTC.terms.names,
    "model.plot()": lambda at: DTC.plot().axes[0].has_data(),
    "print(model)": lambda at: "DTC" in str(DTC),
    "voyage.t": lambda at: voyage().t[0] == 0,
    'voyage["y"]': lambda at: voyage()["y"] is voyage().y,
    "voyage.y[-1]": lambda at: voyage().y[-1] == voyage().outcome.state["y"],
    "voyage.to_xarray()": lambda at: voyage().to_xarray()["y"].attrs["units"] == "m",
    "len(voyage)": lambda at: len(voyage()) == len(voyage().t),
    "controller=lambda t, state: ...": lambda at: (
        nw.simulate(STEERED, 0.0, 1.179, 20.0, contact="none", controller=lambda t, state: 0.1).rudder[-1]
        == pytest.approx(0.1)
    ),
    "voyage.outcome": lambda at: voyage().outcome.kind == "grounded",
    "voyage.to_csv(path)": lambda at: written(at, voyage()) == len(voyage()),
    'ensemble(...)["y"].mean("sample")': lambda at: fleet()["y"].mean("sample").size == 1,
    "nw.linearize(model)": lambda at: nw.linearize(DTC),
    "linear.poles()": lambda at: nw.jacobian(DTC).poles().shape == (6,),
    "nw.Ship(L=230, B=32.2, T=10.8, Cb=0.65)": lambda at: nw.Ship(L=230, B=32.2, T=10.8, Cb=0.65),  # type: ignore[call-arg]
    "nw.read_ship(path).ship.beam": lambda at: nw.read_ship(ship_file(at)).ship.beam == 0.572,
    "ship.to_dict()": lambda at: nw.Ship(**DTC.ship.to_dict()) == DTC.ship,
}
MISSED = {
    "fit.params": "coefficients",
    "fit.standard_errors": "std",
    "fit.fittedvalues": "predict()",
    "model.replace(b_v=1)": "with_coefficients(...)",
    "model.ship.L": "length",
    'ensemble(...)["y"].mean("sample")': "y is where they start; the ends are y_end, psi_end ...",
    "nw.linearize(model)": "nw.jacobian(model), or model.linearize()",
    "nw.Ship(L=230, B=32.2, T=10.8, Cb=0.65)": "words in full: length, beam, draft, block_coefficient",
}
"""Guesses that do not hold, and why, or what to write instead."""


def test_sixty_guesses_of_which_few_are_missed() -> None:
    assert len(GUESSES) == 60
    assert len(MISSED) <= 8
    assert set(MISSED) <= set(GUESSES)


@pytest.mark.parametrize("guess", [name for name in GUESSES if name not in MISSED])
def test_a_guess_holds(guess: str, tmp_path: Path) -> None:
    assert GUESSES[guess](tmp_path)


@pytest.mark.parametrize("guess", MISSED)
def test_a_missed_guess_is_answered(guess: str, tmp_path: Path) -> None:
    with pytest.raises((AttributeError, KeyError, TypeError)) as answer:
        GUESSES[guess](tmp_path)
    if guess.partition(".")[0] in ("fit", "model"):
        assert str(answer.value).endswith(f"write {MISSED[guess]}")
