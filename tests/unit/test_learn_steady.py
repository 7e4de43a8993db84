"""Steady legs: the balance is that of the forces, the answer that of a search over all unknowns; what fails is said."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from scipy.optimize import least_squares

import narrows as nw
from engine_models import mmg, steered
from narrows.logbook import steady_legs
from narrows.logbook.learned_coefficients import coefficient_prior, covered_range
from narrows.logbook.steady_readings import LATENT, UNKNOWN, LegProblem, reading_error, shared_errors, steady_readings

CALM = nw.SteadyConditions(
    wind=0.5, wind_change=0.0, y_zero=0.0, yaw_rate_deg=0.0, yaw_change_deg=0.0, sway_change=0.0,
    y_error=0.02, u_error=0.01, rudder_error_deg=0.5, drift_error_deg=0.1,
)  # fmt: skip
HELD = {"y": [0.5, -0.5, 0.3], "u": [0.8, 0.8, 0.9]}


@cache
def ship(spread: float = 0.05) -> nw.Model:
    """A steered ship by weak banks, whose coefficients are known to a share, those of the bank to none."""
    model = steered().with_coefficients(b_bank=0.3, c_bank=0.04)
    values = np.array([model.coefficients[name] for name in model.terms.names])
    shares = np.array([20 * spread if term.from_bank else spread for term in model.terms.terms])
    return replace(model, covariance=np.diag((shares * values) ** 2))


@cache
def legs(shift_deg: float = 0.0, **changed: float) -> pd.DataFrame:
    """What a ship of other coefficients reads without errors, the rudder off by a zero."""
    truth = ship().with_coefficients(c_bank=0.06, c_helm=3.0, **changed)
    courses = [nw.steady_course(truth, y=y, u=u) for y, u in zip(HELD["y"], HELD["u"], strict=True)]
    angles = {"rudder [deg]": [float(c["rudder"]) for c in courses], "drift [deg]": [float(c["psi"]) for c in courses]}
    frame = pd.DataFrame({**HELD, **{name: np.degrees(column) for name, column in angles.items()}})
    return frame.assign(**{"rudder [deg]": frame["rudder [deg]"] + shift_deg})


@cache
def learned(**changed: float) -> nw.SteadyFit:
    return nw.learn_steady(ship(), legs(**changed), conditions=CALM)


@pytest.mark.parametrize("model", [steered(), mmg()], ids=["steered", "mmg"])
def test_the_balance_is_that_of_the_forces_and_its_slopes_are_theirs(model: nw.Model) -> None:
    places = np.array([[0.4, 0.9, 0.1, 0.03], [-0.7, 1.1, -0.2, -0.05]])
    felt = {"heave": np.array([0.01, 0.02])} | ({"revolutions": np.array([9.0, 10.0])} if model.terms.propelled else {})
    held = {"y": places[:, 0], "u": places[:, 1], "rudder": places[:, 2], "drift": places[:, 3], **felt}
    errors = {name: np.ones(2) for name in ("y", "u", "rudder", "drift")}
    known = replace(model, covariance=np.eye(len(model.terms)))
    problem = LegProblem(coefficient_prior(known, "held"), CALM, nw.SteadyReadings(("A", "B"), held, errors))
    values, state = np.array([model.coefficients[name] for name in model.terms.names]), np.pad(places, ((0, 0), (3, 0)))

    def forces(at: np.ndarray, r: float = 0.0) -> np.ndarray:
        y, u, rudder, psi = at.T
        motion = nw.Motion.at(psi, y=y, u=u, v=-u * np.tan(psi), r=r, heave=felt["heave"])
        found = model.forces(motion, rudder, felt.get("revolutions"))
        return np.stack([found["Y"], found["N"]], axis=-1)

    np.testing.assert_allclose(problem._columns(state) @ values, forces(places), rtol=1e-12)
    slopes, step = problem._slopes(state, values), 1e-6
    for column in range(len(LATENT)):
        aside = step * (np.arange(len(LATENT)) == column)
        by_hand = (forces(places + aside) - forces(places - aside)) / (2 * step)
        np.testing.assert_allclose(slopes[:, :, 3 + column], by_hand, rtol=1e-5, atol=1e-3)
    turning = (forces(places, step) - forces(places, -step)) / (2 * step)
    np.testing.assert_allclose(slopes[:, :, 0], turning, rtol=1e-4, atol=1e-3)
    still, moved = (model.forces(nw.Motion(u=1.0, vdot=rate), 0.0, 9.0 if model.terms.propelled else None)
                    for rate in (0.0, 1.0))  # fmt: skip
    np.testing.assert_allclose(
        slopes[0, :, 1], [moved[name] - still[name] for name in ("Y", "N")], rtol=1e-6, atol=1e-6
    )


def test_the_answer_is_that_of_a_search_over_coefficients_wind_zeros_and_places() -> None:
    """By steady courses that another solver finds, with every unknown free: the same most likely one."""
    model, frame = ship(), legs()
    names = [term.name for term in model.terms.terms if term.name in ("b_bank", "c_bank", "c_helm", "b_uv", "c_uv")]
    known = np.diag([(name in names) * model.covariance[i, i] for i, name in enumerate(model.terms.names)])
    model = replace(model, covariance=known)
    size = np.array([np.sqrt(known[i, i]) for i, name in enumerate(model.terms.names) if name in names])
    read = np.stack([frame["y"], frame["u"], *(np.radians(frame[f"{a} [deg]"]) for a in ("rudder", "drift"))], axis=1)
    error = np.array([reading_error(CALM, name) for name in ("y", "u", "rudder", "drift")])
    mean, shared = np.array([model.coefficients[name] for name in names]), shared_errors(CALM, model)[:4]

    def misfit(x: np.ndarray) -> np.ndarray:
        theta, common, place = np.split(x, [len(names), len(names) + 4])
        place = place.reshape(-1, 2)
        truth = model.with_coefficients(**dict(zip(names, mean + size * theta, strict=True)))
        push = dict(zip(("Y", "N"), shared[:2] * common[:2], strict=True))
        y, u = (xr.DataArray(column, dims="leg") for column in (read[:, :2] + error[:2] * place).T)
        held = nw.steady_course(truth, y=y, u=u, workers=1, **push)
        seen = np.stack([held["rudder"], held["psi"]], axis=1) + shared[2:] * common[2:]
        return np.concatenate([x, ((read[:, 2:] - seen) / error[2:]).ravel()])

    best = least_squares(misfit, np.zeros(len(names) + 4 + 2 * len(read)), xtol=1e-10, ftol=1e-10)
    found = nw.learn_steady(model, frame, conditions=CALM)
    ours = np.array([found.coefficients[name].value for name in names])
    np.testing.assert_allclose((ours - mean) / size, best.x[: len(names)], atol=2e-3)
    assert found.chi_square == pytest.approx(2 * best.cost, abs=2e-3)


def test_the_chi_square_of_a_known_ship_is_the_distance_of_a_leg_from_its_steady_courses() -> None:
    """Another search finds the true place whose steady course is nearest to the readings, in their errors."""
    known = replace(ship(), covariance=np.diag([1e-24 * (name == "c_bank") for name in ship().terms.names]))
    sure = replace(CALM, wind=0.0, rudder_zero_deg=0.0, drift_zero_deg=0.0, y_error=0.1, u_error=0.02)
    read = {"y": 0.5, "u": 0.8, "rudder [deg]": 8.0, "drift [deg]": -0.3}
    error = np.array([reading_error(sure, name) for name in LATENT])

    def distance(place: np.ndarray) -> np.ndarray:
        y, u = (read[name] + size * off for name, size, off in zip(("y", "u"), error, place, strict=False))
        held = nw.steady_course(known, y=y, u=u, workers=1)
        angles = np.radians([read["rudder [deg]"], read["drift [deg]"]]) - [float(held["rudder"]), float(held["psi"])]
        return np.append(place, angles / error[2:])

    nearest = least_squares(distance, np.zeros(2))
    found = LegProblem(coefficient_prior(known, "held"), sure, steady_readings(pd.DataFrame([read]), sure)).fit()
    assert found.converged
    assert found.chi_square == pytest.approx(2 * nearest.cost, rel=1e-6)


def test_a_zero_of_the_rudder_cancels_over_both_sides() -> None:
    loose = replace(CALM, rudder_zero_deg=30.0)
    first, other = (nw.learn_steady(ship(), legs(shift_deg=shift), conditions=loose) for shift in (0, 2.0))
    moved = abs(other.coefficients["c_bank"].value - first.coefficients["c_bank"].value)
    assert moved < 0.1 * first.std["c_bank"]
    assert np.degrees(other.shared["rudder_zero"][0] - first.shared["rudder_zero"][0]) == pytest.approx(2.0, abs=0.1)


def test_mirrored_legs_teach_the_same() -> None:
    frame = legs(shift_deg=0.7)
    mirrored = frame.assign(**{name: -frame[name] for name in ("y", "rudder [deg]", "drift [deg]")})
    first, other = (nw.learn_steady(ship(), rows, conditions=CALM) for rows in (frame, mirrored))
    for name in first.coefficients:
        assert other.coefficients[name].value == pytest.approx(first.coefficients[name].value, rel=1e-7)
    for name in UNKNOWN:
        assert other.shared[name][0] == pytest.approx(-first.shared[name][0], rel=1e-6, abs=1e-12)


def test_what_was_learned_and_what_was_not_is_said() -> None:
    found = learned()
    assert found.verdicts["c_bank"] == "learned"
    assert found.verdicts["b_vdot"] == "from the prior"
    assert found.informative
    assert "c_bank is 0.0" in found.summary().splitlines()[0]
    assert "on simulated twins only" in found.summary()
    assert "on simulated twins only" in found.notes[-1]
    assert found.model.verdicts["c_bank"] == "identified"
    assert "learned from 3 legs from -0.5 to +0.5 m" in found.model.source.text
    assert nw.learn_steady(found.model, legs(), conditions=CALM).std["c_bank"] < found.std["c_bank"]


def test_a_bank_whose_effect_is_zero_is_unresolved() -> None:
    truth = {"b_bank": 0.0}
    model = ship().with_coefficients(b_bank=0.1)
    wide = replace(model, covariance=replace(ship(), covariance=ship().covariance).covariance + np.diag(
        [0.3**2 if name == "b_bank" else 0.0 for name in model.terms.names]))  # fmt: skip
    found = nw.learn_steady(wide, legs(**truth), conditions=CALM)
    assert found.verdicts["b_bank"].endswith("unresolved")
    assert "unresolved, for 0 is among it" in found.coefficients["b_bank"].sentence()


def test_legs_on_one_side_are_said_to_cancel_nothing() -> None:
    frame = legs()
    found = nw.learn_steady(ship(), frame[frame["y"] > 0], conditions=CALM)
    assert any("one side" in note for note in found.notes)
    assert not any("one side" in note for note in learned().notes)


@pytest.mark.parametrize("name", ["rudder", "drift"])
def test_another_sign_is_found_and_told(name: str) -> None:
    frame = legs()
    turned = frame.assign(**{f"{name} [deg]": -frame[f"{name} [deg]"]})
    found = nw.learn_steady(ship(), turned, conditions=replace(CALM, rudder_error_deg=0.1, drift_error_deg=0.05))
    assert any(f"other sign of {name}" in note for note in found.notes)
    assert not any("other sign" in note for note in learned().notes)


def test_a_leg_that_does_not_fit_the_others_is_named() -> None:
    frame = pd.concat([legs()] * 3, ignore_index=True)
    frame.loc[4, "rudder [deg]"] += 8.0
    found = nw.learn_steady(ship(), frame, conditions=CALM)
    assert found.contradicted
    assert not found.informative
    assert found.model.verdicts["c_bank"].startswith("contradicted")
    assert "leg 5 fits worst" in " ".join(found.notes)
    assert min(found.leg_probabilities, key=found.leg_probabilities.__getitem__) == "5"


def test_a_table_without_drift_is_told_what_to_head_so() -> None:
    with pytest.raises(
        nw.InputError, match="no column 'drift', heading minus course over ground, or minus the canal's"
    ):
        nw.learn_steady(ship(), legs().rename(columns={"drift [deg]": "heading [deg]"}), conditions=CALM)


def test_legs_of_one_name_are_refused() -> None:
    with pytest.raises(nw.InputError, match="two legs have the same name; give each a name of its own"):
        nw.learn_steady(ship(), legs().assign(leg="port"), conditions=CALM)


def test_the_range_in_a_section_that_no_test_had_is_that_of_the_legs() -> None:
    tested = nw.DataRange(speed=(0.5, 2.0), abs_y=(0.0, 2.5), width_to_beam=(30.0, 30.0))
    found = covered_range(replace(ship(), data_range=tested), (0.3, 0.5), (0.8, 0.9))
    assert found.speed == (0.5, 0.9)
    assert found.abs_y == (0.0, 0.5)
    assert found.width_to_beam == pytest.approx((7.0 / 0.572, 7.0 / 0.572))
    known = replace(tested, width_to_beam=found.width_to_beam)
    same = covered_range(replace(ship(), data_range=known), (0.3, 3.0), (0.8, 0.9))
    assert (same.speed, same.abs_y) == ((0.5, 2.0), (0.0, 3.0))
    kcs = nw.published("estimated_kcs")  # 10.8 m of draft in 16.2 m of water
    shallow = covered_range(kcs.with_canal(depth=12.96), (0.0, 30.0), (3.0, 5.0))
    assert shallow.depth_to_draft == pytest.approx((1.2, 1.2))
    assert covered_range(kcs, (0.0, 30.0), (3.0, 5.0)).depth_to_draft == kcs.data_range.depth_to_draft


def test_files_and_mappings_are_read_alike(tmp_path: Path) -> None:
    frame = legs().assign(leg=["a", "b", "c"], remark="fine")
    frame.to_csv(tmp_path / "held.csv", index=False)
    first, other = steady_readings(tmp_path / "held.csv", CALM), steady_readings(frame.to_dict("list"), CALM)
    for one, two in ((first.values, other.values), (first.errors, other.errors)):
        pd.testing.assert_frame_equal(pd.DataFrame(one), pd.DataFrame(two))
    assert first.legs == ("a", "b", "c")
    assert first.source == "held.csv"


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"rudder [deg]": None}, "has no column 'rudder'"),
        ({"drift [deg]": None}, "has no column 'drift"),
        ({"u": [0.8, -0.8, 0.9]}, "u over 0"),
        ({"y": [0.5, -9.0, 0.3]}, "has the hull in the bank"),
        ({"rudder [deg]": None, "rudder": [5.0, -5.0, 4.0]}, "rudder \\[deg\\]"),
        ({"y_error": [0.1, -1.0, 0.1]}, "y_error is a finite number from 0"),
        ({"u": [0.8, "fast", 0.9]}, "mend the cell"),
    ],
)
def test_rows_that_are_no_legs_are_refused_in_a_sentence(change: dict[str, list | None], said: str) -> None:
    frame = legs().drop(columns=[name for name, column in change.items() if column is None])
    with pytest.raises(nw.InputError, match=said):
        nw.learn_steady(ship(), frame.assign(**{name: column for name, column in change.items() if column is not None}))


def test_what_is_no_coefficient_and_no_leg_is_refused_in_a_sentence() -> None:
    with pytest.raises(nw.InputError, match="targets = 5: give names of coefficients"):
        nw.plan_steady(ship(), targets=5)
    with pytest.raises(nw.InputError, match="has no leg; give a row for each side and speed"):
        nw.learn_steady(ship(), legs().head(0))


def test_the_notes_name_a_search_that_stopped_early() -> None:
    fit = learned()
    assert fit.intervals == {name: own.interval for name, own in fit.coefficients.items()}
    problem = LegProblem(coefficient_prior(ship(), "held"), CALM, steady_readings(legs(), CALM))
    found = problem.fit()
    said = "The search for the true states of the legs did not converge; give smaller errors of y and u."
    for converged in (True, False):
        notes = [*steady_legs._findings(problem, found._replace(converged=converged), "1", 0.5)]
        assert (said in notes) is not converged


def test_models_that_cannot_learn_are_refused_in_a_sentence() -> None:
    with pytest.raises(nw.InputError, match="no terms of a rudder"):
        nw.learn_steady(nw.published("mikkelsen2025_dtc"), legs())
    with pytest.raises(nw.InputError, match="no covariance"):
        nw.learn_steady(steered(), legs())
