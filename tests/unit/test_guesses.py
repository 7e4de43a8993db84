"""Sixty guesses of a user of pandas, xarray, scikit-learn, statsmodels, SciPy and python-control, written down before
the names of the package were looked at. Those that do not hold are listed with why."""

import copy
import json
import pickle
import re
from collections.abc import Callable
from functools import cache
from operator import attrgetter
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
import xarray as xr
from scipy.integrate import solve_ivp

import narrows as nw
from narrows.base.aliases import aliases
from tables import DTC_SHIP, frame_of, short_twin

DTC = nw.published("mikkelsen2025_dtc")
STEERED = nw.published("yasukawa2015_kvlcc2")
KCS = nw.published("estimated_kcs")


@cache
def fit() -> nw.Fit:
    return nw.identify(short_twin())


def estimator() -> nw.estimation.Estimator:
    return nw.estimation.Estimator(DTC, [nw.estimation.Gnss(), nw.estimation.Gyro()])


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


def table_file(folder: Path) -> Path:
    frame_of(short_twin()).to_csv(folder / "tests.csv", index=False)
    return folder / "tests.csv"


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
    "nw.concat([tests, tests])": lambda at: nw.concat([TESTS(), TESTS()]),  # type: ignore[attr-defined]
    'tests.save("t.parquet")': lambda at: (
        TESTS().save(at / "t.parquet") or len(pd.read_parquet(at / "t.parquet")) == 445
    ),
    "tests.to_xarray()": lambda at: "Y" in TESTS().to_xarray(),
    'fit.coefficients["b_v"]': lambda at: fit().coefficients["b_v"] > 0,
    "fit.params": lambda at: fit().params == fit().coefficients,
    "fit.conf_int()": lambda at: tuple(fit().conf_int().loc["b_v"]) == fit().intervals["b_v"],
    'fit.rsquared["Y"]': lambda at: 0.9 < fit().rsquared["Y"] <= 1,
    "fit.score(tests)": lambda at: fit().score(TESTS())["Y"].r2 == pytest.approx(fit().rsquared["Y"]),
    'fit.rmse["Y"]': lambda at: fit().rmse["Y"] == pytest.approx(fit().residuals["Y"].pow(2).mean() ** 0.5, rel=0.01),
    "fit.covariance": lambda at: fit().covariance.shape == (17, 17),
    "fit.standard_errors": lambda at: fit().standard_errors == fit().std,
    "fit.nobs": lambda at: fit().nobs == TESTS().rows,
    "fit.predict(df)": lambda at: np.allclose(fit().predict(frame_of(TESTS())), fit().predict()),
    "fit.fittedvalues": lambda at: len(fit().fittedvalues) == fit().nobs,
    "fit.to_csv(path)": lambda at: written(at, fit()) == 17,
    "fit.tests": lambda at: len(fit().tests) == 4,
    "pickle a fit": lambda at: pickle.loads(pickle.dumps(fit())).coefficients == fit().coefficients,
    "fit.plot().savefig(path)": lambda at: fit().plot().savefig(at / "a.png") or (at / "a.png").stat().st_size > 0,
    'fit.intervals["b_v"]': lambda at: fit().intervals["b_v"][0] < fit().intervals["b_v"][1],
    'model["b_v"]': lambda at: DTC["b_v"] == DTC.coefficients["b_v"],
    "model.coefficients.items()": lambda at: len(DTC.coefficients.items()) == 17,
    "model.replace(b_v=1)": lambda at: DTC.replace(b_v=1.0)["b_v"] == 1.0,
    "nw.Model.load(path)": lambda at: nw.Model.load(saved(at)).coefficients == DTC.coefficients,
    "nw.Model.from_dict(model.to_dict())": lambda at: nw.Model.from_dict(DTC.to_dict()) == DTC,
    "model == loaded": lambda at: nw.load_model(saved(at)) == DTC and DTC.with_coefficients(b_v=1.0) != DTC,
    "pickle a model": lambda at: pickle.loads(pickle.dumps(DTC)) == DTC,
    "model.simulate(y=0.5)": lambda at: DTC.simulate(y=0.5).outcome == voyage().outcome,
    "model.linearize(y=0.5)": lambda at: DTC.linearize(y=0.5).A.shape == (4, 4),
    "model.scale(length=355)": lambda at: DTC.scale(length=355.0).model.ship.length == 355.0,
    "solve_ivp(model.derivative)": lambda at: np.allclose(sailed()[:2], [voyage().x[50], voyage().y[50]], atol=1e-7),
    "model.forces(y=[...], u=1)": lambda at: DTC.forces(y=np.array([0.0, 0.5]), u=1.0)["Y"].shape == (2,),
    "model.ship.L": lambda at: DTC.ship.L == 3.984,
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
    "nw.Ship(L=230, B=32.2, T=10.8, Cb=0.65)": lambda at: nw.Ship(L=230, B=32.2, T=10.8, Cb=0.65).beam == 32.2,  # type: ignore[call-arg]
    "nw.read_ship(path).ship.beam": lambda at: nw.read_ship(ship_file(at)).ship.beam == 0.572,
    "ship.to_dict()": lambda at: nw.Ship(**DTC.ship.to_dict()) == DTC.ship,
}
SECTIONS = {
    "ship": {"length": 3.984, "beam": 0.572, "draft": 0.163, "block_coefficient": 0.661}, "canal": {"width": 7.0},
}  # fmt: skip
FRESH: dict[str, Callable[[Path], Any]] = {
    "nw.identify(path, ship=path)": lambda at: nw.identify(table_file(at), ship=ship_file(at)).nobs == TESTS().rows,
    "nw.identify(df, ship={...})": lambda at: nw.identify(frame_of(TESTS()), ship=SECTIONS).nobs == TESTS().rows,
    "nw.compare(df, ship=path)": lambda at: nw.compare(frame_of(TESTS()), "paper", ship=ship_file(at)).fits,
    "nw.explain(model, df)": lambda at: nw.explain(DTC, frame_of(TESTS()), ["paper"]).scores,
    'fit["b_bank"]': lambda at: fit()["b_bank"] == fit().coefficients["b_bank"],
    "json.dumps(fit.to_dict())": lambda at: json.dumps(fit().to_dict()),
    "len(fit.terms.names)": lambda at: len(fit().terms.names) == 17,
    "for test in tests": lambda at: sum(test.rows for test in TESTS()) == TESTS().rows,
    "model.turning_circle(20)": lambda at: STEERED.turning_circle(20.0, 1.0).advance > 0,
    "model.squat(u=0.5)": lambda at: DTC.with_canal(depth=0.3).squat(u=0.5).sinkage > 0,
    "model.to_python()": lambda at: "numpy" in DTC.to_python(),
    "voyage.save(gif)": lambda at: voyage().save(at / "v.gif") is None and (at / "v.gif").exists(),
    'tests["yaw"]': lambda at: TESTS()["yaw"].names == ("yaw",),
    'tests.drop("yaw")': lambda at: "yaw" not in TESTS().drop("yaw").names and len(TESTS().drop("yaw")) == 3,
    "copy.deepcopy(model) == model": lambda at: copy.deepcopy(DTC) == DTC,
    "model.with_canal(width=10)": lambda at: DTC.with_canal(width=10.0).configuration.canal.width == 10.0,
    'model.forces(y=0.5, u=1.0)["Y"]': lambda at: float(DTC.forces(y=0.5, u=1.0)["Y"]) > 0,
    "model.to_json()": lambda at: json.loads(DTC.to_json())["ship"]["beam"] == 0.572,
    "voyage.grounded": lambda at: voyage().grounded is True,
    "voyage.duration": lambda at: voyage().duration == voyage().t[-1],
    'voyage.to_dataframe().plot(x="x", y="y")': lambda at: voyage().to_dataframe().plot(x="x", y="y").has_data(),
    "fleet.distance.sel(y=0.5)": lambda at: nw.ensemble(DTC, y=[0.1, 0.5]).distance.sel(y=0.5) > 0,
    "fleet.to_dataframe()": lambda at: len(nw.ensemble(DTC, y=[0.1, 0.5]).to_dataframe()) == 2,
    "nw.control.linearize(model)": lambda at: nw.control.linearize(STEERED, y=0.0, u=1.0),
    "linear.bode(input=, output=)": lambda at: KCS.linearize(u=4.0).bode(input="rudder", output="r").axes.size == 2,
    'linear.tf("rudder", "psi")': lambda at: KCS.linearize(u=4.0).tf("rudder", "psi").noutputs == 1,
    "linear.discretize(0.5)": lambda at: KCS.linearize(u=4.0).discretize(0.5).dt == 0.5,
    "np.linalg.matrix_rank(linear.ctrb())": lambda at: np.linalg.matrix_rank(KCS.linearize(u=4.0).ctrb()) == 4,
    "nw.predict(model, tests)": lambda at: len(nw.predict(DTC, TESTS())) == TESTS().rows,  # type: ignore[attr-defined]
    "model.to_latex()": lambda at: "aligned" in DTC.to_latex(),
    "model.froude_depth(u)": lambda at: KCS.froude_depth(4.0) == pytest.approx(4.0 / np.sqrt(9.81 * 16.2)),
    "nw.export.c(model)": lambda at: "DTC" in nw.export.c(DTC) and not nw.export.c(DTC, at / "a.h"),
    "comparison.table": lambda at: len(nw.compare(TESTS(), "paper").table) == 3,
    "linear.is_stable": lambda at: not KCS.linearize(u=4.0).is_stable,
    "linear.dcgain()": lambda at: KCS.linearize(u=4.0).dcgain().shape == (4, 2),
    "model.eigenvalues(u=4)": lambda at: len(KCS.eigenvalues(u=4.0)) == 4,
    "nw.nomoto(model, u=4)": lambda at: nw.nomoto(KCS, u=4.0).K > 0,  # type: ignore[attr-defined]
    "fit.tvalues": lambda at: fit().tvalues["b_v"] == pytest.approx(fit()["b_v"] / fit().std["b_v"]),
    "model.blockage": lambda at: KCS.blockage == pytest.approx(32.2 * 10.8 / (300 * 16.2)),
    "voyage.min_clearance": lambda at: abs(voyage().min_clearance) < 1e-6,
    "solve_ivp(model.rhs, ...)": lambda at: solve_ivp(DTC.rhs, (0.0, 1.0), [0.0, 0.5, 0.0, 1.0, 0.0, 0.0]).success,
    "nw.PD(kp, kd)": lambda at: (
        nw.simulate(KCS, u=4.0, psi=0.1, duration=9.0, controller=nw.PD(1.0, 9.0)).rudder.min() < 0
    ),  # type: ignore[attr-defined]
    "np.linalg.eigvals(model.linearize(y=0.5).A)": lambda at: np.linalg.eigvals(DTC.linearize(y=0.5).A).size == 4,
}
"""Of forty more, written down before they were tried, those that hold."""
ANSWERED: dict[str, tuple[Callable[[], Any], str]] = {
    "CaptiveTests(frame)": (lambda: nw.CaptiveTests([1.0]), r"'names'; nw.read_captive\(path, ship\) makes one"),  # type: ignore[call-arg, arg-type]
    "model.with_depth": (lambda: DTC.with_depth(24.0), r"write nw.at_depth\(model, depth\)"),  # type: ignore[attr-defined]
    "regulator(model, u)": (lambda: nw.control.regulator(DTC, u=5.0), "'y'; its arguments: model, y, u"),  # type: ignore[call-arg]
    "Estimator(model)": (lambda: nw.estimation.Estimator(DTC), "'sensors'; its arguments: model, sensors"),  # type: ignore[call-arg]
    "model.export(language, path)": (
        lambda: DTC.export("c", "dtc.h"),
        "too many positional arguments; its arguments: path",
    ),  # type: ignore[call-arg]
    "nw.Tests(path)": (lambda: nw.Tests("tests.csv"), r"nw.read_captive\(path, ship\) makes one"),  # type: ignore[attr-defined]
    "nw.compare(tests, models=)": (
        lambda: nw.compare(TESTS(), models=["estimated_kcs"]),  # type: ignore[call-arg]
        r"nw.explain\(model, tests\) has the errors",
    ),
    "voyage.to_kml(path)": (lambda: voyage().to_kml("v.kml"), r"write save\(path\), .geojson for a track"),  # type: ignore[attr-defined]
    "nw.plot_voyages": (lambda: nw.plot_voyages, r"write voyage.plot\(label=...\)"),  # type: ignore[attr-defined]
    "nw.convert": (lambda: nw.convert, "the unit in the text"),  # type: ignore[attr-defined]
    "tests[0].t": (lambda: nw.measured_tests("kcs")[0].t, "over the rows"),
    "nw.identify(form=)": (lambda: nw.identify(short_twin(), form="distance"), r"'paper\+distance' for another bank"),  # type: ignore[call-arg]
    "model.plot_forces(u=1.0)": (lambda: DTC.plot(u=1.0), "has the numbers at a speed"),  # type: ignore[call-arg]
    "model.forces(0.5, 0.0, 1.0)": (lambda: DTC.forces(0.5, 0.0, 1.0, 0.0, 0.0), "give them by name"),  # type: ignore[arg-type]
    "nw.bank_force(None)": (lambda: nw.bank_force(None, 1.0, 1.0, width=9.0), "None is no model"),  # type: ignore[arg-type]
    "nw.sensitivities(voyage)": (lambda: nw.sensitivities(voyage()), "is no model; give nw.published"),  # type: ignore[arg-type]
    "fit.interval(name, level=0.9)": (lambda: fit().interval("b_v"), "intervals are of 95 %; write intervals"),  # type: ignore[attr-defined]
    "model.b_bank": (lambda: DTC.b_bank, r"write model\['b_bank'\]"),  # type: ignore[attr-defined]
    "nw.plot_envelope": (lambda: nw.plot_envelope, "write safe_envelope"),  # type: ignore[attr-defined]
    "nw.froude": (lambda: nw.froude, "write scale_model"),  # type: ignore[attr-defined]
    "nw.step_response": (lambda: nw.step_response, "state_space"),  # type: ignore[attr-defined]
    "nw.simulate(..., T=20)": (lambda: nw.simulate(DTC, y=0.5, T=20), "write duration"),
    "nw.simulate(..., hold=0)": (lambda: nw.simulate(DTC, y=0.5, hold=0), "has no terms of a rudder; take a ship"),
    "nw.zigzag(model)": (lambda: nw.zigzag(DTC), "nw.borrow_rudder adds a rudder"),
    "controller=lqr(...)": (
        lambda: nw.simulate(KCS, u=4.0, controller=nw.control.lqr(KCS, 1, 1, u=4.0)),
        r"nw.control.regulator\(model, y, u\) is one",
    ),
    "nw.cross_validate(tests, cv=5)": (lambda: nw.cross_validate(TESTS(), cv=5), "write identify"),  # type: ignore[attr-defined]
    "nw.simulate(x0=[...])": (lambda: nw.simulate(DTC, x0=[0.0, 0.5, 0.0, 1.0, 0.0, 0.0]), "x is the place along"),
    "fit.pvalues": (lambda: fit().pvalues, "write verdicts"),  # type: ignore[attr-defined]
    "nw.simulate(..., t_span=)": (lambda: nw.simulate(DTC, y=0.5, t_span=(0, 9)), "write duration"),
    "nw.simulate(..., y=1, y0=1)": (lambda: nw.simulate(DTC, y=0.5, y0=0.5), "y0 and y are one argument"),
    "fit.popt": (lambda: fit().popt, "write coefficients"),  # type: ignore[attr-defined]
    "fit.aic": (lambda: fit().aic, "rows of one run are not independent; write left_out"),  # type: ignore[attr-defined]
    "nw.simulate(..., wind=5)": (lambda: nw.simulate(DTC, y=0.5, wind=5.0), "nw.wind_force"),
    "nw.simulate(rudder_angle=)": (lambda: nw.simulate(STEERED, rudder_angle=0.1), "in degrees for turning"),
    "nw.identify(method=)": (lambda: nw.identify(short_twin(), method="ols"), "mixed model of errors"),
    "nw.Autopilot(kp=)": (lambda: nw.Autopilot(kp=1.0), "Autopilot has no argument 'kp'; write gains="),  # type: ignore[call-arg]
    "nw.control.regulatr": (lambda: nw.control.regulatr, "did you mean 'regulator'"),
    "nw.warn": (lambda: nw.warn, "or `narrows monitor` in a terminal"),  # type: ignore[attr-defined]
    "model.set(b_v=1)": (lambda: DTC.set(b_v=1.0), r"write with_coefficients\("),  # type: ignore[attr-defined]
    "model.to_simulink()": (lambda: DTC.to_simulink(), r"write export\(path\), with .fmu"),  # type: ignore[attr-defined]
    "nw.plot_map": (lambda: nw.plot_map, "write report.map_figure"),  # type: ignore[attr-defined]
    "linear.is_controllable()": (lambda: DTC.linearize().is_controllable(), r"matrices\(\), and python-control.s ctrb"),
    "model.coefficients[a name of another table]": (
        lambda: KCS.coefficients["b_bank"],
        "of the bank are Y_bank, N_bank",
    ),
    "nw.read_captive(df, ship=nw.Ship(...))": (
        lambda: nw.read_captive(frame_of(TESTS()), ship=DTC.configuration.ship),
        r"give tests.configuration",
    ),
    "nw.Monitor(model).feed(sentence)": (lambda: nw.Monitor(STEERED).feed("$"), "--replay FILE reads NMEA sentences"),
    "voyage.measure(sensors)": (lambda: voyage().measure(), r"write voyage.to_dataframe\(\)"),
    "nw.Canal(bank_slope=)": (lambda: nw.Canal(300.0, 16.0, bank_slope=0.3), "nw.equivalent_wall the wall of one"),  # type: ignore[call-arg]
    "canal.blockage": (lambda: nw.Canal(300.0, 16.0).blockage, "under beam . draft of the ship"),  # type: ignore[attr-defined]
    "nw.lqr(3)": (lambda: nw.lqr(3, Q=1, R=1), "neither a linear system nor a model"),  # type: ignore[attr-defined]
    "nw.MPC(model, dt=)": (lambda: nw.MPC(KCS, dt=0.5), "write horizon=... .s. and intervals="),  # type: ignore[attr-defined]
    "nw.rts_smoother": (lambda: nw.rts_smoother, r"smooth\(records\)"),  # type: ignore[attr-defined]
    "nw.report.write_raport": (lambda: nw.report.write_raport, "did you mean 'write_report'"),
    "voyage.plot(1)": (lambda: voyage().plot(1), "is no Axes of Matplotlib"),  # type: ignore[arg-type]
    "nw.simulate(y_deg=)": (lambda: nw.simulate(DTC, y_deg=5.0), "no argument 'y_deg'"),
    "nw.turning_circle(rudder_rad=)": (lambda: nw.turning_circle(KCS, rudder_rad=0.5), "no argument|unexpected"),  # type: ignore[call-arg]
    "voyage.y_deg": (lambda: voyage().y_deg, "Voyage has no 'y_deg'"),  # type: ignore[attr-defined]
    "nw.with_helm": (lambda: nw.with_helm, r"by its name with \+helm"),  # type: ignore[attr-defined]
    "model.coefficients.b_banck": (lambda: DTC.coefficients.b_banck, "did you mean 'b_bank'"),  # type: ignore[attr-defined]
    "outcome.success": (lambda: voyage().outcome.success, "write kind"),  # type: ignore[attr-defined]
    "loop.step()": (
        lambda: nw.control.closed_loop(KCS, nw.control.regulator(KCS, 0.0, 4.0)).step(),  # type: ignore[attr-defined]
        r"write state_space\(\) for python-control",
    ),
    "fit.posterior": (lambda: fit().posterior, "write coefficients, std and intervals"),  # type: ignore[attr-defined]
    "fit.P": (lambda: fit().P, "write covariance"),  # type: ignore[attr-defined]
    "estimator.P": (lambda: estimator().P, r"write update\(t, ...\): the estimate"),  # type: ignore[attr-defined]
    "estimator.smooth()": (lambda: estimator().smooth(), "'records'; its arguments: records"),  # type: ignore[call-arg]
    'nw.identify(errors="ridge")': (
        lambda: nw.identify(short_twin(), errors="ridge"),  # type: ignore[arg-type]
        r"give nw.RunErrors\(",
    ),
    "nw.identify(alpha=)": (lambda: nw.identify(short_twin(), alpha=0.1), r"write fit.intervals: .* 95 %"),  # type: ignore[call-arg]
    "model.nondimensional()": (lambda: DTC.nondimensional(), "give a positive one, speed="),  # type: ignore[attr-defined]
    "nw.crash_stop(model)": (lambda: nw.crash_stop(DTC), r"nw.published\('estimated_kcs'\)"),
    'nw.squat(formula="barrass")': (lambda: nw.squat(KCS, 4.0, "bow", "barrass"), "leave gives out"),
    "nw.turning_circle(wind_speed=)": (lambda: nw.turning_circle(KCS, wind_speed=8), "its arguments: model, rudder"),  # type: ignore[call-arg]
    "nw.wind_force(wind_speed=)": (lambda: nw.wind_force(wind_speed=8.0, area=1e3), "write speed=..., of the wind"),  # type: ignore[call-arg]
    "nw.scale(scale_factor=)": (lambda: nw.scale(DTC, scale_factor=89.11), "write length=... of the other ship"),  # type: ignore[attr-defined]
    "model.to_full_scale": (lambda: DTC.to_full_scale(89.11), r"write scale\(length\)"),  # type: ignore[attr-defined]
    "tests.split()": (lambda: TESTS().split(test_size=0.25), r"write nw.identify\(tests\).left_out"),
    "nw.compare_models": (lambda: nw.compare_models, r"explain.model, tests. for each"),  # type: ignore[attr-defined]
    "nw.monitor(model, path)": (lambda: nw.monitor(KCS, "bridge.csv"), r"write Monitor\(model\).run\(log\)"),  # type: ignore[attr-defined]
    "nw.simulate(current=)": (lambda: nw.simulate(DTC, current=0.5), r"nw.straight_waterway\(model.canal, 20_000\)"),
    "nw.passing": (lambda: nw.passing, "forces between ships are not modelled"),  # type: ignore[attr-defined]
    "nw.load_voyage(path)": (lambda: nw.load_voyage, r"open_dataset\(path\)"),  # type: ignore[attr-defined]
    "voyage.forces": (lambda: voyage().forces, r"model.forces\(y=voyage.y"),  # type: ignore[attr-defined]
    "nw.plan(criterion=)": (lambda: nw.plan(DTC, criterion="D"), "minimise the sum of the variances"),  # type: ignore[attr-defined]
    "model.plot(hue=)": (lambda: DTC.plot(hue="x"), "columns of its table"),
    "nw.froude_depth": (lambda: nw.froude_depth, "write choke_speed, or u / np.sqrt"),  # type: ignore[attr-defined]
    "nw.Sensors": (lambda: nw.Sensors, "write a list of sensors"),  # type: ignore[attr-defined]
    "voyage.rot": (lambda: voyage().rot, "in degrees a minute"),  # type: ignore[attr-defined]
    "waterway.save(path)": (
        lambda: nw.straight_waterway(nw.Canal(300.0, 16.0), 5000.0).save("own.geojson"),  # type: ignore[attr-defined]
        r"write waterway.to_geojson\(path\)",
    ),
    "Waterway.from_geojson(width=)": (
        lambda: nw.Waterway.from_geojson("axis.geojson", width=300.0),  # type: ignore[attr-defined]
        "needs a depth; give depth",
    ),
    "nw.load_ship(name)": (lambda: nw.load_ship("kcs"), "nw.published has the package's ships"),  # type: ignore[attr-defined]
    "nw.simulate(heading_deg=)": (lambda: nw.simulate(DTC, heading_deg=2.0), "write psi=..., in radians"),
    "nw.simulate(n_steps=)": (lambda: nw.simulate(DTC, n_steps=100), "write duration=... and dt=..."),
    "nw.safe_envelope(wind=)": (lambda: nw.safe_envelope(KCS, wind=10.0), r"write disturbance=nw.Disturbance\("),  # type: ignore[call-arg]
    "nw.regulator(Q=)": (
        lambda: nw.control.regulator(KCS, 0.0, 4.0, Q=1.0),
        "write weights=nw.control.RegulatorWeights",
    ),
    "Estimator(P0=)": (
        lambda: nw.estimation.Estimator(KCS, [nw.estimation.Gnss()], P0=1.0),  # type: ignore[call-arg]
        "write prior=nw.estimation.Prior",
    ),
    "nw.read_captive(sep=)": (
        lambda: nw.read_captive("tests.csv", sep=";"),
        "decimal commas and encoding are detected",
    ),  # type: ignore[call-arg]
    "nw.ExtendedKalmanFilter": (lambda: nw.ExtendedKalmanFilter, "write estimation.Estimator"),  # type: ignore[attr-defined]
}
"""Those that do not, and what they are told."""
MISSED = {
    'ensemble(...)["y"].mean("sample")': "y is where they start; the ends are y_end, psi_end ...",
    "nw.concat([tests, tests])": "nw.read_captive of their data frames, joined",
}
"""Guesses that do not hold, and why, or what to write instead."""

LATER = """
assert nw.Gnss is nw.estimation.Gnss and nw.estimation.UKF is nw.estimation.Estimator
assert nw.control.mpc is nw.mpc is nw.control.PredictiveHelm
assert nw.simulate(fit, y=0.1).t[-1] == fit.simulate(y=0.1).t[-1]
assert nw.simulate("mikkelsen2025_dtc", y=0.5).grounded
assert fit.linearize(u=1.0).A.shape == fit.model.linearize(u=1.0).A.shape
assert nw.Model.load("mikkelsen2025_dtc") == pub and nw.load_tests is nw.read_captive
assert nw.regulator is nw.control.regulator and nw.closed_loop is nw.control.closed_loop
assert nw.simulate(nw.scale_model(pub, 355.0), y=5.0).final["u"] > 1
assert fit.ship.length == fit.model.configuration.ship.length
fig, ax = plt.subplots(); fit.plot(ax=ax)
tests[tests["test"] == "yaw"]
fleet.grounded.mean().item()
fit.bse; fit.cov()
model.save("m.toml"); nw.load("m.toml") == model
voyage.to_netcdf("v.nc")
tests.groupby("test").mean()
assert tests.mean()["u"] == tests.u.mean() and tests.filter("y > 0").rows == tests.query("y > 0").rows
assert fit.ci().equals(fit.conf_int()) and fit.conf_int().equals(fit.confidence_intervals())
assert nw.Ship(length=230.0, beam=32.2, draft=10.8, block=0.65).block_coefficient == 0.65
assert model.bank_force(0.5, 1.0).Y == nw.bank_force(model, y=0.5, psi=0.0, u=1.0).Y
tests.plot()
tests.names[0]
tests.u.mean()
tests["Y"].std()
tests.groupby("test")["Y"].max()
tests.iloc[0]
tests.sample(10)
assert nw.read_ais is nw.read_log
assert np.allclose(nw.lqr(kcs, Q=[1, 1, 1, 1], R=1)[0], nw.lqr(kcs.linearize(), np.eye(4), np.eye(2))[0])
tests.isna().sum()
tests.to_numpy().shape
tests.copy()
tests.canal.depth
fit.coefficients.keys()
fit.summary().splitlines()[0]
fit.to_dict()["coefficients"]["b_v"]
fit.residuals.hist()
fit.std["b_v"]
fit.verdicts["b_bank"]
fit.notes
fit.cov_params().shape
fit.resid["Y"].plot()
np.sqrt(np.diag(fit.covariance))
fit.intervals["b_v"]
fit.model.save("m.toml")
model.latex()
model.forces(u=np.linspace(0, 1, 5))["X"].shape
model.water.density
model.terms.names
model.to_dict()["ship"]["beam"]
model["b_bank"]
model.with_coefficients({"b_bank": 0.0})["b_bank"]
"b_bank" in model.coefficients
model.plot()
model.linearize(y=0.5, u=1.0).A
voyage.x.max()
voyage.loc[:50]
voyage.describe()
voyage.iloc[-1]
pd.DataFrame(voyage).tail()
for row in voyage: row.t, row.y
voyage.to_parquet("v.parquet")
voyage.to_xarray().y.plot()
voyage.resample
plt.plot(voyage.x, voyage.y)
fig, (a, b) = plt.subplots(1, 2); voyage.plot(ax=a); fit.plot(ax=b)
voyage.outcome.time
voyage.outcome.side == "port"
nw.simulate(model, y=0.1, u=0.4, duration=5).grounded
fleet.grounded.sum().item()
fleet.time.max().item()
fleet.isel(u=0).distance.to_series()
fleet.where(fleet.grounded).distance
nw.ensemble(model, y=0.1, u=0.4, samples=10).grounded.mean("sample")
nw.published()
nw.jacobian(pub, y=0.5, u=1.0).eigenvalues()
nw.scale_model(pub, length=355).model.ship.length
nw.Ship(length=4.0, beam=0.6, draft=0.2, block_coefficient=0.65)
nw.read_captive(tests.to_dataframe(), ship=tests.configuration)
nw.identify(tests.to_dataframe(), ship=tests.configuration)
import polars as pl; pl.DataFrame(voyage)
assert fit.r2 == fit.rsquared and fit.parameters == fit.params and len(fit.get_influence()) == 4
assert voyage.heading is voyage.psi and voyage.rudder_angle is voyage.rudder and voyage.yaw_rate is voyage.r
assert voyage.distance == voyage.outcome.distance and voyage.message == voyage.outcome.sentence
assert nw.simulate(pub, y0=0.5, u0=1.0, t_end=5.0).y[0] == 0.5
assert nw.ensemble(pub, y0=[0.5, 1.0], speed=1.0).to_xarray().grounded.size == 2
nw.straight_canal(nw.Canal(W=300.0, h=16.0), 5000.0).plot()
assert pub.copy() == pub and pub.draft == pub.ship.draft and pub.width == pub.configuration.canal.width
assert nw.load_model("mikkelsen2025_dtc") == pub
assert model.predict(u=1.0, y=0.5)["Y"] == model.forces(u=1.0, y=0.5)["Y"]
assert len(model.linearize(u=1.0).damp()) == 4
assert pub.forces(u=1.0, y=[0.1, 0.2])["N"].shape == (2,)
assert kcs.rudder.area == kcs.configuration.rudder.area and kcs.ship.LBP == kcs.ship.Lpp == 230
assert nw.turning_circle(kcs, 35, speed=6.0).tactical_diameter > 0 and nw.zigzag_test is nw.zigzag
assert nw.get_model("mikkelsen2025_dtc") == pub and nw.export_c is nw.export.write
assert round(nw.straight_canal(nw.Canal(W=300.0, h=16.0), 5000.0).centerline.length, 6) == 5000
assert len(nw.grounding_map(pub, y=[0.5, 1.0]).to_dataframe()) == 2 and nw.ols(tests).terms.names == fit.terms.names
assert fit.confidence().low.b_v == fit.intervals['b_v'][0]
assert all(pickle.loads(pickle.dumps(one)) == one for one in (fit, voyage, tests)) and nw.simulate(pub, y=0.4) != voyage
assert len(voyage[0:10]) == 10
assert fit.n_samples == fit.nobs and tests.n_samples == tests.n_rows == tests.rows and fit.std_err == fit.std
assert nw.map(pub, y=[0.5, 1.0], speed=1.0).outcomes.equals(nw.ensemble(pub, y=[0.5, 1.0], u=1.0).outcome)
assert nw.simulate(pub, y_m=0.5, speed_ms=1.0, psi_rad=0.0, sim_time=1.0, step_size=0.05).t[-1] == 1.0
circle = nw.run_turning_circle(kcs, 35, u=6.0)
assert circle.trajectory.heading is circle.psi and len(circle.df) == len(circle.t)
circle.to_csv("circle.csv"); assert nw.run_zigzag(kcs, 20, 20).overshoots[0] > 0 and voyage.hit_bank
assert len(nw.emergency_stop(kcs, speed=4.0).to_dataframe()) > 0 and nw.model_comparison is nw.compare
assert "overshoots_deg" in dir(nw.zigzag(kcs))
sens = nw.sensitivity_analysis(pub, params=("b_bank",), duration=1.0)
assert sens.gradients is sens.slopes and len(sens.df) == len(sens.voyage.t)
assert pub.sensitivity(duration=1.0).parameters and pub.clone() == pub
assert nw.squat(kcs, 4.0, method="icorels", gives="bow").squat > 0 and nw.Vessel is nw.Ship
assert nw.rescale(pub, length_m=355.0, rho=1025.0).scale_factor == nw.scale_model(pub, 355.0).ratio
assert nw.Compass is nw.estimation.Gyro and nw.estimation.GPS is nw.gps is nw.estimation.Gnss
assert nw.Waterway.from_geojson is nw.read_waterway and nw.doe is nw.plan_tests
assert nw.linearization is nw.control.linearize
same = nw.simulate(model=pub, y=0.5, Y_ext=0.0, N_ext=0.0, V=1.0, duration=1.0)
assert same == nw.simulate(vessel=pub, y=0.5, u=1.0, tf=1.0)
assert nw.wind_force(speed=10.0, windage=5.0, Cd=0.9) == nw.wind_force(10.0, 5.0, 0.9)
assert nw.squat(kcs, V=4.0, where="bow") == nw.squat(kcs, 4.0, "bow") and nw.GPS(1.0, late=0.5).delay == 0.5
assert nw.load(name="mikkelsen2025_dtc") == pub and nw.WarningMonitor is nw.Monitor and nw.export.write
assert nw.Gnss(latency=0.4).late == 0.4 and nw.Gnss().straight and nw.Canal(300.0, 16.0).water_depth == 16.0
assert pub.data_range.shown("speed") and pub.canal.W == pub.canal.width and voyage.outcome.reason == voyage.outcome.kind
assert nw.estimation.Estimator("estimated_kcs", [nw.Gnss(), nw.Gyro()]).filter.model == nw.load("estimated_kcs")
assert nw.zigzag(kcs, rudder_deg=20, heading_deg=20, duration=600.0, dt=1.0).voyage.t[-1] <= 600.0
assert nw.turning_circle(kcs, rudder_angle=35, time_step=1.0).advance > 0 and nw.Gnss(std=0.5).noise == 0.5
assert nw.KalmanFilter is nw.estimation.Estimator and nw.report.make_report is nw.report.write_report
assert fit.cov_params().loc['b_v', 'b_v'] == fit.covariance.iloc[5, 5]
assert nw.squat(kcs, "8 kn") == nw.squat(kcs, speed=8 * 1852 / 3600) and nw.simulate(pub, u="3.6 km/h").u[0] == 1.0
assert nw.ensemble(pub, u="1 m/s").equals(nw.ensemble(pub, u=1.0))
F = nw.forces(pub, u=1.0, offset=np.linspace(-1.0, 1.0, 5)); assert F.Y is F["Y"] and F.N.shape == (5,)
assert pub.coefficients.to_pandas().loc["b_v"] == pub.coefficients.b_v == pub["b_v"]
assert fit.condition_number["Y"] == fit.condition_number.Y > 1
fit.params.sort_values(); fit.bse.round(3); fit.coefficients.to_frame()
assert nw.simulate(pub, y_m=0.5, psi_deg=2.0, u_knots=1.0).u[0] == 1852 / 3600 and np.isclose(voyage.psi_deg[0], 0.0)
assert np.allclose(np.radians(voyage.heading_deg), voyage.psi) and voyage.speed_knots[0] == 3600 / 1852
assert nw.ensemble(pub, speed_knots=[1.0, 2.0]).u.values[1] == 2 * 1852 / 3600
assert nw.squat(kcs, speed_kmh=18.0) == nw.squat(kcs, 5.0) and nw.turning_circle(kcs, speed_knots=12).advance > 0
assert nw.list_models() == nw.published() and nw.simulate(pub, v="0.1 m/s", duration=1.0).v_kn[0] == 360 / 1852
assert pub.scale(100.0).model.coefficients.b_v and pub.with_canal(width=8.0).coefficients.b_v
assert tests[0].names == tests.names[:1] and len(tests[:2]) == 2 and tests.n_tests == len(tests)
assert nw.safe_speed is nw.safe_envelope and model.describe() == model.info() == model.summary()
assert voyage.time_to_grounding == voyage.outcome.time and voyage.max_yaw_rate == abs(voyage.r).max()
assert fleet.time_to_grounding.max() > 0 and voyage.n_steps == len(voyage.t) and np.isclose(voyage.dt, 0.02)
test = nw.zigzag(kcs, 10, 10)
assert [test.first_overshoot, test.second_overshoot] == list(test.overshoots_deg[:2]) and test.max_overshoot > 0
A, B = kcs.linearize(u=4.0)
assert np.allclose(nw.lqr(kcs, Q=1, R=1, speed=4.0)[0], nw.lqr(kcs.linearize(u=4.0), 1, 1)[0])
assert kcs.linearize().C.shape == (4, 4) and kcs.linearize().D.shape == kcs.linearize().B.shape
assert voyage.final_speed == voyage.u[-1] and abs(voyage.drift_angle[-1]) < 1
big, wide = dict(length=366.0, beam=51.0, draft=15.0, block=0.65), dict(width=420.0, depth=24.0)
config = nw.Configuration(nw.Ship(**big), nw.Canal(**wide)); assert nw.Configuration(**big, **wide) == config
assert nw.squat(**big, **wide, speed="8 kn") == nw.squat(ship=config.ship, canal=config.canal, speed=8 * 1852 / 3600)
assert nw.choke_speed(L=366.0, B=51.0, T=15.0, Cb=0.65, W=420.0, h=24.0) == nw.choke_speed(config)
assert nw.estimate_model(**big, **wide) == nw.estimate_model(config.ship, config.canal)
assert nw.straight_waterway(**wide, length="5000 m").line.length > 4999
assert nw.simulate(kcs, u=4.0, rudder="10deg", duration="1 s").rudder[0] == np.radians(10)
assert nw.turning_circle(kcs, "35 deg").advance == nw.turning_circle(kcs, 35).advance
assert nw.squat(kcs, 4.0).bow == nw.squat(kcs, 4.0, "bow").sinkage and 4 < nw.squat(kcs, 4.0).ukc < 5.4
assert nw.straight_waterway(**wide).line.length > 9_999
assert "b_bank  " in fit.summary() and "b_bank  " not in fit._repr_html_().partition("<table")[0]
assert [test.name for test in tests] == [*tests.names] and tests.name == tests.ship.name
pub.save("ship.toml"); assert nw.read_ship("ship.toml").ship == pub.ship
assert voyage.outcome.grounded and not nw.simulate(kcs, y=5.0, hold=0, duration=30.0).outcome.grounded
assert -1 <= fit.correlation.loc["b_v", "b_r"] == fit.corr().b_v.b_r <= fit.correlation.loc["b_v", "b_v"] < 1.01
assert "b_v  " in str(fit) and str(voyage) == voyage.summary() and fit.verdicts["b_vdot"].is_identified
ax = voyage.plot_track(); ax.set_title("DTC at 1 m/s"); assert ax.axes[0].get_title() == "DTC at 1 m/s"
assert nw.estimated(nw.Ship(**big), **wide) == nw.estimate_model(**big, **wide)
assert nw.Tests.from_dataframe(tests.to_dataframe(), ship=tests.configuration).rows == tests.rows
X, Y, N = kcs.forces(y=60.0, u=4.0); assert Y == kcs.forces(y=60.0, u=4.0)["Y"] == dict(kcs.forces(y=60.0, u=4.0))["Y"]
assert nw.simulate(pub, y="0.5 m", duration="0.1 min") == nw.simulate(pub, y=0.5, duration=6.0)
assert fit.covariance.loc["b_bank", "b_r"] == fit.covariance.loc["b_r", "b_bank"]
assert fit.conf_int(alpha=0.05).equals(fit.conf_int()) and "Y_bank" in str(kcs) and "Y_bank" not in kcs.summary()
assert nw.equilibrium(kcs, y=40.0, u=4.0).delta == nw.steady_course(kcs, y=40.0, u=4.0).rudder
held = nw.ensemble(kcs, y=[20.0, 40.0], u=[3.0, 5.0], hold=0.0, duration=50.0)
voyage = nw.simulate(kcs, y=40.0, u=5.0, hold=0.0, duration=50.0); assert abs(held.y_end[1, 1] - voyage.y[-1]) < 1e-6
assert nw.ensemble(kcs, u=4.0, draws=2, hold=0.0, duration=9.0).sizes == {"sample": 2}
assert nw.simulate(pub, width=9.0, duration=1.0) == nw.simulate(pub.with_canal(width=9.0), duration=1.0)
assert repr(fit.summary()) == str(fit) and json.dumps(voyage.summary())[0] == '"'
sunk = nw.squat(kcs, u=np.arange(1.0, 5.0)); assert sunk.sinkage[3] == nw.squat(kcs, 4.0).sinkage and len(sunk.df) == 4
assert type(sunk.to_dict()["summary"]) is str
assert sunk.bow[3] == nw.squat(kcs, 4.0).bow and str(sunk) and len(fit.plot_fit().axes) == 3
assert fit.cov.loc["b_v", "b_r"] == fit.cov().b_v.b_r and fit.vif() == fit.vif and fit.r2() == fit.rsquared
assert pickle.loads(pickle.dumps(fit.corr)).equals(fit.correlation()) and fit.conf_int.equals(fit.conf_int(alpha=0.05))
K, S, E = nw.lqr(kcs, Q=1, R=1, u=4.0); assert np.array_equal(nw.lqr(kcs, Q=1, R=1, u=4.0).K, K) and K.shape == (2, 4)
assert nw.cross_validate(tests).rmse["N"] == fit.left_out["N"].rmse == nw.left_out_error(fit)["N"].rmse
best = nw.compare(tests, ["paper", "speed"]).best; assert best.N == best["N"] == best("N")
draws = fit.sample(n_samples=300, seed=1); assert abs(draws["b_bank"].std() / fit.std["b_bank"] - 1) < 0.2
assert kcs.with_coefficients(kcs.draws(2).loc[1])["Y_bank"] == kcs.sample(2).Y_bank[1] != kcs["Y_bank"]
assert (tests.filter(speed=(0.3, 9)).u >= 0.3).all()
assert tests.select("y > 0", y=(-1, 1), yaw_moment=(-9, 9)).y.min() > 0
assert tests.filter(name="yaw").names == ("yaw",) == tests.filter(test=["yaw", "a", "b"]).names
assert nw.simulate(pub, y="50 cm", duration=9) == nw.simulate(pub, y_mm=500, duration=9) != nw.simulate(pub, y="1 ft")
assert nw.simulate(pub, r="60 deg/min", duration=9) == nw.simulate(pub, r="1 deg/s", duration=9)
assert voyage.y_end == voyage.y[-1] and voyage.plot_heading().axes[0].get_xlabel() == "t"
assert voyage.plot_speed("u.png").axes
assert "1 test" in tests.filter(test="yaw").summary()
told = nw.explain(pub, tests, ["paper"]); assert told.table().shape[0] == 17
assert told.rmse.Y == told.scores["Y"].rmse and told.r2["N"] == told.scores["N"].r2
assert model.predict(tests)["Y"].equals(fit.predict().Y) and len(model.predict(tests.to_dataframe())) == tests.rows
assert nw.simulate(kcs, u=4, rpm=60, duration=9) == nw.simulate(kcs, u=4, n=1.0, duration=9)
assert nw.crash_stop(kcs, rpm=-60).distance == nw.crash_stop(kcs, revolutions="-60 rpm").distance
assert nw.Tests.from_dataframe(tests.to_dataframe(), ship=tests.ship).configuration == tests.configuration
assert voyage.at(voyage.t[5]).y == voyage.y[5] and len(voyage.interp([1.0, 2.0])) == 2
assert nw.ukc(kcs, u=5.0) == kcs.under_keel_clearance(u=5.0) == nw.squat(kcs, 5.0).ukc
assert kcs.poles(u=4.0).shape == (4,) and kcs.advance(35) == nw.turning_circle(kcs, 35).advance
steered = nw.simulate(kcs, u=4, rudder=lambda t, s: 0.1 - s.r, duration=9); assert steered.rudder[-1] > 0
ordered = nw.simulate(kcs, u=4, rudder=lambda t: 0.1, duration=9); assert abs(ordered.rudder[-1] - 0.1) < 1e-9
wide = nw.turning_circle(kcs, np.deg2rad(35)); assert "radians" in str(wide.notes)
assert abs(wide.advance / kcs.advance(35) - 1) < 1e-9
assert nw.squat(kcs, 5.0, method="barrass").gives == "largest"
assert len(kcs.linearize().ABCD) == len(kcs.linearize().ssdata()) == 4
ax = voyage.plot(label="free", color="k"); assert steered.plot(ax=ax, label="steered").get_legend().get_texts()
assert len(tests.plot(["Y", "N"]).axes) == len(voyage.plot(x="t", y=["psi", "r"]).axes) == 2
assert model.plot(title="T", figsize=(6, 4)).axes[0].get_title() == "T" and tests.plot("Y").axes
assert nw.compare(tests, terms=["paper"]).fits and nw.Ship(L=4.0, B=0.6, T=0.2, Cb=0.65, xG=0.1).x_g == 0.1
"""
"""Those of two more lists of sixty and seventy that hold, as they were written."""
LATER_DEAR = """
assert nw.safe_envelope(kcs, speeds=[4.0], offsets=[0.0], n_samples=2).grid["held"].size == 1
assert nw.safety_envelope(kcs, y=[0.0], u=[4.0], samples=2).speeds.item() == 4.0
assert nw.safe_envelope(kcs, u="8 kn", y=[0.0], samples=2).speeds.item() > 4.1
nw.export_model(pub, "dtc.h"); nw.to_python(pub, outfile="dtc.py"); nw.write_model(pub, "dtc.toml")
nw.export(pub, "c", "again.h")
nw.html_report({"C": fit}, "fit.html")
nw.to_c(pub, "dtc.h", language="c")
nw.export(pub, "dtc.py"); nw.export(fit, path="fit.h")
tank = nw.Tank(speeds=[0.9]); planned = nw.plan(tests, runs=2, tank=tank)
assert nw.plan(fit, runs=2, tank=tank).notes == planned.notes
assert nw.plan(model=tests, runs=2, tank=tank).notes == planned.notes
assert nw.plan(tests.ship, runs=2, after=tests, tank=tank).notes == planned.notes
fit.export("fit.h")
assert nw.export.c(pub) == pub.to_c()
env = nw.safe_envelope(kcs, ys=[0.0], speeds=[4.0], ukc=1.0, rudder_reserve=0.2, n_samples=2, verbose=False)
assert env.data.attrs["reserve"] == 0.2
assert nw.safe_envelope(kcs, y=[0.0], u=[4.0], samples=2, confidence=0.95).speeds.size == 1
assert (kcs.estimate_states(kcs.simulate(u=4, duration=5).df).v_std > 0).all()
log = kcs.simulate(u=4, duration=5).df
assert nw.kalman_filter(kcs, log)["v"].shape == kcs.estimate_states(log).t.shape
assert nw.plan(pub, runs=2, tank=tank).runs and planned.runs
env = nw.envelope(kcs, width=300.0, depth=16.0, y=[-9.0, 0.0, 9.0], u=[4.0, 5.0], samples=9)
assert env.max_offset(u=4.5) == 9.0
nw.animate(nw.simulate(pub, y=1.0, duration=2.0), "a.gif", seconds=0.2)
assert voyage.plot("chart.png").axes and plt.imread("chart.png").std() > 0
boot = nw.bootstrap(tests, n=20, seed=1)
assert boot.std()["b_v"] == fit.bootstrap(20, 1).std["b_v"] and len(boot.df) == 20
fixed = nw.identify(tests, fixed={"b_bank": 0, "b_vdot": 60.0}); assert fixed["b_bank"] == fixed.std["b_bank"] == 0
assert fixed.intervals["b_vdot"] == (60.0, 60.0) and fixed.bootstrap(9).samples[:, 3].std() == 0 and fixed.left_out
drawn = nw.monte_carlo(kcs, n=3, y=20, u=4, duration=60)
assert drawn.probability("grounded") == (drawn.outcome == "grounded").mean()
"""
"""Those of them that take most time."""
LATER_MISSED = {
    "pd.DataFrame(tests)": "they are several tables: tests.to_dataframe()", "fit.conf_int(0.9)": "only the 95 % ones",
    "model(u=1.0, y=0.5)": "model.forces(...)",
    "nw.simulate(pub, y=0.5, heading=0.1)": "psi, in radians",
    "nw.datasets.load_kcs()": "measured_tests",
    'nw.published("dtc")': "its name in full",
}  # fmt: skip
"""Those that do not, and what is written instead."""


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


@pytest.mark.parametrize("guess", FRESH)
def test_a_fresh_guess_holds(guess: str, tmp_path: Path) -> None:
    assert FRESH[guess](tmp_path)


@pytest.mark.parametrize("guess", ANSWERED)
def test_a_fresh_guess_is_answered(guess: str) -> None:
    ask, told = ANSWERED[guess]
    with pytest.raises((AttributeError, KeyError, nw.InputError), match=told):
        ask()


def test_a_name_that_nothing_is_near_is_said_to_be_absent() -> None:
    with pytest.raises(AttributeError, match=r"narrows has no 'qqq'$"):
        nw.qqq  # type: ignore[attr-defined]  # noqa: B018
    with pytest.raises(AttributeError, match="did you mean 'read_captive'"):
        nw.red_captive  # type: ignore[attr-defined]  # noqa: B018


def later_names() -> dict[str, Any]:
    names = {"np": np, "pd": pd, "plt": plt, "nw": nw, "tests": TESTS(), "fit": fit(), "model": fit().model, "pub": DTC}
    return names | {
        "pickle": pickle,
        "json": json,
        "kcs": KCS,
        "voyage": voyage(),
        "fleet": nw.ensemble(DTC, y=[0.5, 1.0, 2.4], u=[0.8, 1.0]),
    }


def test_later_guesses_hold(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names = later_names()
    for guess in LATER.strip().splitlines():
        exec(guess, names)
        plt.close("all")
    for guess in LATER_MISSED:
        with pytest.raises((AttributeError, TypeError, nw.InputError)):
            exec(guess, names)


def test_later_guesses_that_are_dear_hold(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names = later_names()
    for guess in LATER_DEAR.strip().splitlines():
        exec(guess, names)


def test_names_of_other_libraries_that_are_answered_are_listed() -> None:
    listed = dir(fit())
    assert {"params", "bse", "ci", "pcov", "cov", "resid", "coefficients", "summary"} <= set(listed)
    assert not {"popt", "pvalues", "poles"} & set(listed)
    assert all(hasattr(fit(), name) for name in listed)


def test_every_answer_names_something_that_exists() -> None:
    """Results by their names in the answers, and each row that is one public name."""
    results = {"fit": fit(), "voyage": voyage(), "model": DTC}
    for row in aliases("other_functions"):
        for holder, part in re.findall(r"\b(fit|voyage|model)\.(\w+)", row):
            assert hasattr(results[holder], part), row
        for name in re.findall(r"^[\w.]+(?=$|\(|,| or )|(?<= or )[\w.]+(?=$|\(|,)", row):
            if name.partition(".")[0] not in {*results, "help", "8"}:
                assert attrgetter(name)(nw) is not None, row


def test_numbers_of_the_command_line_have_units(cli: Callable[..., tuple[int, str, str]]) -> None:
    start = ["simulate", "estimated_kcs", "--speed", "8kn", "--duration"]
    plain = cli(*start, 20, "--y", 5.0, "--rudder-deg", 2.0, "--json")
    assert plain == cli(*start, "20s", "--y", "5 m", "--rudder-deg", "2deg", "--json")
    assert plain[0] == 0
    for words, told in {
        "zigzag estimated_kcs --angle-deg 10": "write --zigzags 10/10",
        "monitor full.toml --file a.nmea": "--replay FILE",
        "monitor full.toml --udp 10110": "--listen udp://:10110",
        "monitor full.toml --serial /dev/ttyS0": "--listen udp://:10110, tcp://HOST:PORT",
        "export simulink full.toml": "no kind 'simulink'; choose bank-force", "estimate --ship panamax": "and --type",
        "identify a.csv --bank-form distance": r"--terms paper+distance",
    }.items():  # fmt: skip
        assert told in cli(*words.split())[2]


def test_verbs_show_a_model_and_its_zigzags_under_other_names(cli: Callable[..., tuple[int, str, str]]) -> None:
    code, out, err = cli("info", "mikkelsen2025_dtc")
    assert code == 0, err
    assert "b_bank" in out
    shown = json.loads(cli("show", "estimated_kcs", "--json")[1])
    assert [row["ship"] for row in shown["ships"]] == ["KCS"]
    assert shown["notes"]
    code, out, err = cli("zigzag", "yasukawa2015_kvlcc2", "--speed", 1.179, "--angle", 10, "--rudder", 20)
    assert code == 0, err
    assert "10/10" in out


def test_forces_are_arrays_and_those_of_the_bank_are_unpacked() -> None:
    forces = DTC.forces(u=1.0, y=0.5)
    assert [*np.array(forces)] == [forces["X"], forces["Y"], forces["N"]]
    Y, N = nw.bank_force(DTC, y=0.5, u=1.0)
    assert [Y, N] == pytest.approx([forces["Y"], forces["N"]])


def test_coefficients_do_not_change_in_place() -> None:
    for of in (DTC, fit()):
        for change in (
            lambda own: own.update(b_bank=1.0),
            lambda own: own.__setitem__("b_bank", 1.0),
            lambda own: setattr(own, "b_bank", 1.0),
        ):
            with pytest.raises(nw.InputError, match=r"write model.with_coefficients\("):
                change(of.coefficients)
        assert pickle.loads(pickle.dumps(of.coefficients)) == copy.deepcopy(of.coefficients) == of.coefficients
        assert [*of] == [*of.coefficients] == [*dict(of)]
        assert "b_bank" in of
        assert "bank" not in of


def test_a_result_equals_the_word_for_it() -> None:
    assert voyage().outcome == "grounded" != "afloat"
    assert voyage().outcome == copy.deepcopy(voyage().outcome) != 1
    assert fit().verdicts["b_bank"] == fit().verdicts["b_bank"].status != "unknown"
    fleet = nw.ensemble(DTC, y=[0.1, 0.5])
    assert (fleet.outcome == "grounded").values.tolist() == fleet.grounded.values.tolist() == [True, True]
    assert not (fleet["outcome"] != "grounded").any()
    assert (fleet.outcome == fleet.outcome).all()
    with pytest.raises(nw.InputError, match="choose not run or afloat or grounded"):
        fleet.outcome == "sunk"  # noqa: B015


def test_columns_have_their_other_names_in_brackets() -> None:
    assert voyage()["heading"] is voyage().psi
    assert TESTS()["yaw_moment"] is TESTS()["N"]
    assert [*TESTS()[["v", "N"]].columns] == [*voyage()[["v", "r"]].columns[:1], "N"]


def test_methods_accept_the_other_names_of_arguments() -> None:
    names = {"y": [0.0, 20.0], "u": [3.0, 5.0], "samples": 10}
    envelope = nw.safe_envelope(KCS, **names)
    assert envelope.highest_speed(offset="10 m").equals(envelope.highest_speed(10.0))
    assert voyage()[-1].equals(voyage().final)
    assert voyage()[voyage().t > 5]["t"].min() > 5
    with pytest.raises(nw.InputError, match="is no share from 0 to 1"):
        envelope.safe(20.0)


@pytest.mark.parametrize(
    ("ask", "told"),
    [
        ("float(nw.squat(nw.published('estimated_kcs'), 4.0))", "a Squat is no number; take one of its own: sinkage"),
        ("nw.control.lqr(model, Q=1, R=1)", "has no controls, so no gains; nw.borrow_rudder"),
        ("fit.conf_int(alpha=0.1)", "conf_int takes no arguments here: intervals are of 95 %; write conf_int"),
        ("nw.measured_squat()", "write pandas.read_csv of lataire2009_squat.csv"),
        ("f'{model:.2f}'", "a Model is no number"),
        ("model.plot(x='x')", "column = 'x' is unknown"),
        ("model.bank_forces(u=1.0)", "write motion=nw.Motion"),
        ("nw.simulate(model, y=0.5, rudder=lambda t: 0.1)", "for which this model has no terms"),
        ("nw.control.damp", "write nw.damp"),
        ("nw.control.zigzag", "write nw.zigzag"),
        ("nw.export.save_model", "write nw.save_model"),
        ("model.residual_plot", r"write plot\(\)"),
        ("model.pivot_table", r"write to_dataframe\(\).pivot_table"),
        ("model.forces(4.0)", "give quantities by name"),
        ("model[0]", "unknown coefficient 0"),
        ("nw.simulate(model, nu0=1.0, T=20)", "has no argument 'nu0'"),
    ],
)
def test_what_is_elsewhere_is_named(ask: str, told: str) -> None:
    with pytest.raises((AttributeError, TypeError, nw.InputError), match=told):
        eval(ask, {"nw": nw, "model": DTC, "fit": fit()})
