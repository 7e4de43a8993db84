"""Linear systems about steady courses: against differences, python-control, the engine's voyages and stability."""

import json
from functools import cache

import control
import numpy as np
import pytest
from cases import mmg, paper
from cases import steered as kinked
from matplotlib.figure import Figure

import narrows as nw
from narrows.base.files import to_json
from narrows.base.results import BaseResult
from narrows.control import LinearSystem, linearize
from narrows.control.steady_course import LocalMotion, local_water, steady_courses
from narrows.simulation.ship import SimulatedShip
from narrows.waterway import Bank, Centreline, Waterway

RADIUS = 60.0


@cache
def steered() -> nw.Model:
    """Without terms of |r|: they have a kink on straight courses, where exact slopes are the mean of both sides."""
    return kinked().with_coefficients(
        **{
            f"{axis}_{kind}": 0.0
            for axis in "abc"
            for kind in ("vr", "rv", "rr")
            if f"{axis}_{kind}" in kinked().coefficients
        }
    )


def unkinked() -> nw.Model:
    """The published model without its terms of |v| and |r|."""
    return paper().with_coefficients(**{f"{axis}_{kind}": 0.0 for axis in "bc" for kind in ("vv", "rr")})


TURN = "a bend of 60 m radius, in a current"
CASES = {
    "near the middle": (steered, {"y": 0.1}), "beside a bank": (steered, {"y": 0.25, "N": 0.4, "Y": -0.7}),
    "with a propeller": (mmg, {"y": 0.8}), "a speed that is free": (mmg, {"y": 0.8, "surge": "free"}),
    "a free speed without a propeller": (steered, {"y": 0.2, "surge": "free", "surge_inertia": 280.0}),
    "without a rudder": (unkinked, {"y": 0.3}),
    TURN: (steered, {"y": 0.4, "at": 100.0}),
    f"{TURN}, the speed free": (mmg, {"y": 0.4, "at": 100.0, "surge": "free"}),
}  # fmt: skip


@cache
def bend(width: float = 14.0, aside: float = 0.0) -> Waterway:
    """An arc, its line off the middle of the water."""
    turned = np.linspace(0, 3.0, 601)
    line = Centreline(RADIUS * np.stack([1 - np.cos(turned), np.sin(turned)], axis=1))
    s = np.array([0.0, line.length])
    starboard, port = (
        Bank(side, s, np.full(2, width / 2 + off)) for side, off in (("starboard", aside), ("port", -aside))
    )
    return Waterway(line, starboard, port, current=0.1)


def system(case: str) -> LinearSystem:
    make, told = CASES[case]
    return linearize(make(), u=1.0, waterway=bend(aside=0.3) if "at" in told else None, **told)


def central(function, about: np.ndarray, widths: np.ndarray) -> np.ndarray:
    steps = np.diag(widths)
    return np.stack([(function(about + h) - function(about - h)) / (2 * h.max()) for h in steps], axis=1)


def motion(case: str) -> LocalMotion:
    make, told = CASES[case]
    given = {name: value for name, value in told.items() if name in ("Y", "N")}
    ship = SimulatedShip(make(), told.get("surge", "held"), told.get("surge_inertia"))
    water = local_water(make(), bend(aside=0.3) if "at" in told else None, told.get("at", 0.0))
    return steady_courses(ship, water, np.array([told["y"]]), np.ones(1), given)[0]


@pytest.mark.parametrize("case", CASES)
def test_matrices_are_central_differences(case: str) -> None:
    linear, ship = system(case), motion(case)
    names = (*linear.states, *linear.controls, *linear.disturbances)

    def rates(at: np.ndarray) -> np.ndarray:
        found = ship.rates({**linear.course, **dict(zip(names, at, strict=True))})
        return np.array([float(found[name]) for name in linear.states])

    widths, course = np.array([1e-7 if n == "curvature" else 1e-5 for n in names]), [linear.course[n] for n in names]
    found = np.hstack([linear.A, linear.B, linear.G])
    np.testing.assert_allclose(found, central(rates, np.array(course), widths), rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(rates(np.array(course)), 0.0, atol=1e-10)


def test_a_state_space_has_names() -> None:
    linear = system("with a propeller")
    plant = linear.state_space()
    assert plant.state_labels == list(linear.states)
    assert plant.input_labels == [*linear.controls, *linear.disturbances]
    np.testing.assert_array_equal(plant.A, linear.A)
    np.testing.assert_array_equal(plant.B, np.hstack([linear.B, linear.G]))


@pytest.mark.parametrize("model", [steered, mmg], ids=["steered", "mmg"])
def test_eigenvalues_are_those_of_the_stability(model) -> None:
    linear = linearize(model(), y=0.3, u=1.0)
    at = {name: float(linear.course[name]) for name in ("psi", "v", "rudder", "revolutions") if name in linear.course}
    np.testing.assert_allclose(
        linear.eigenvalues(), nw.stability(model(), y=0.3, u=1.0, **at)["eigenvalue"].values.ravel(), rtol=1e-9
    )
    modes = linear.modes()
    np.testing.assert_allclose(modes["growth"], linear.eigenvalues().real, rtol=1e-9)
    length = model().configuration.ship.length
    shapes = modes[list(linear.states)].to_numpy().T * np.array([length, 1.0, 1.0, 1 / length])[:, None]
    values = (modes["growth"] + 1j * modes["angular_frequency"]).to_numpy()
    np.testing.assert_allclose(linear.A @ shapes, shapes * values, atol=1e-9)


@pytest.mark.parametrize("model", [steered, mmg], ids=["steered", "mmg"])
def test_the_steady_turn_along_a_bend_is_a_voyage_that_stays_on_its_line(model) -> None:
    way = bend(aside=0.3)
    course = linearize(model(), y=0.4, u=1.0, waterway=way, at=60.0).course
    told = {
        name: float(course[name]) for name in ("y", "u", "psi", "v", "r", "rudder", "revolutions") if name in course
    }
    voyage = nw.simulate(model(), x=60.0, waterway=way, duration=4.0, dt=0.05, **told)
    for name in ("y", "psi", "v", "r"):
        np.testing.assert_allclose(voyage[name], told[name], atol=2e-4, err_msg=name)
    assert abs(told["r"] - 1.1 / RADIUS) < 0.02 / RADIUS
    assert abs(told["rudder"]) > 0.01


def test_a_free_speed_is_held_by_its_propeller_and_a_force() -> None:
    course = linearize(mmg(), y=0.8, u=1.0, surge="free").course
    told = {name: float(course[name]) for name in ("y", "u", "psi", "v", "r", "rudder", "revolutions", "X")}
    assert told["revolutions"] == pytest.approx(nw.self_propulsion(mmg(), 1.0))
    assert told["X"] > 0
    voyage = nw.simulate(mmg(), surge="free", duration=3.0, dt=0.05, **told)
    np.testing.assert_allclose(voyage.u, 1.0, atol=1e-6)
    ahead = linearize(mmg(), u=1.0, surge="free").course
    assert float(ahead["X"]) == pytest.approx(0.0, abs=1e-9 * told["X"])
    towed = linearize(steered(), y=0.2, u=1.0, surge="free", surge_inertia=280.0)
    assert float(towed.course["X"]) > 0
    assert towed.states == ("y", "psi", "u", "v", "r")


def test_where_no_rudder_holds_it_it_is_refused() -> None:
    strong = steered().with_coefficients(c_bank=40.0)
    with pytest.raises(nw.InputError, match=r"no rudder holds this ship at y = 3 m and 1 m/s"):
        linearize(strong, y=3.0, u=1.0)
    hard = linearize(steered(), y=0.25, u=1.0, N=-18.0)
    assert hard.course["rudder"] > np.radians(25.0)
    assert "this course needs more than the 25 degrees that the rudder turns" in hard.notes


def test_it_speaks_like_other_results(tmp_path) -> None:
    linear = linearize(mmg(), y=0.5, u=1.0)
    assert isinstance(linear, BaseResult)
    told = json.loads(to_json(linear.to_dict()))
    assert told["summary"] == linear.summary()
    assert told["units"]["current"] == "m/s"
    assert any("flow over the rudder" in note for note in linear.notes)
    assert len(repr(linear)) < 200
    assert linear.summary().split()[0] in linear._repr_html_()
    assert isinstance(linear.plot(), Figure)
    for name in ("a.json", "a.svg", "a.csv"):
        linear.save(tmp_path / name)


@pytest.mark.parametrize(
    ("told", "words"),
    [
        ({"y": 9.0}, "has the hull in the bank"),
        ({"u": 0.0}, "needs a speed over 0"),
        ({"u": "fast"}, "must be a finite number"),
        ({"y": [0.1, 0.2]}, "must be a finite number"),
        ({"b_bnk": 1.0}, "has no 'b_bnk'"),
        ({"rudder": 0.1}, "the rudder .* is sought"),
        ({"at": 5.0}, "is a place along a waterway"),
        ({"waterway": bend(), "at": 500.0}, "is beyond waterway"),
        ({"waterway": bend(0.5), "at": 5.0}, "wide at 5 m"),
        ({"waterway": "canal.geojson"}, "no such file"),
        ({"surge": "loose"}, "surge"),
        ({"surge": "free"}, "surge_inertia"),
        ({"N": np.nan}, "N"),
    ],
    ids=str,
)
def test_what_cannot_be_linearised_is_one_sentence(told, words) -> None:
    with pytest.raises(nw.InputError, match=words):
        linearize(steered(), **told)


def test_a_ship_without_a_rudder_is_held_by_the_forces_that_its_course_tells() -> None:
    linear = paper().linearize(y=0.5, u=1.0)
    assert linear.B.shape == (4, 0)
    course = {name: float(value) for name, value in linear.course.items()}
    felt = paper().forces(y=0.5, u=1.0)
    assert (course["Y"], course["N"]) == (pytest.approx(-felt["Y"]), pytest.approx(-felt["N"]))
    with pytest.raises(nw.InputError, match="it is sought"):
        linearize(paper(), y=0.5, u=1.0, N=1.0)


def test_nomotos_indices_are_those_of_a_step_of_the_rudder() -> None:
    """The yaw rate goes to K, and the area between it and K is K (T1 + T2 - T3), by an integration of sway and yaw."""
    linear = nw.published("estimated_kcs").in_open_water().linearize(u=4.0)
    found, (A, b) = linear.nomoto(), linear.matrices("rudder")
    step, z, area = 0.2, np.zeros(2), 0.0
    for _ in range(20_000):
        before, z = z, z + step * (A[2:, 2:] @ (z + step / 2 * (A[2:, 2:] @ z + b[2:, 0])) + b[2:, 0])
        area += step * (found.K - (before[1] + z[1]) / 2)
    assert z[1] == pytest.approx(found.K, rel=1e-6)
    assert area / found.K == pytest.approx(found.T, rel=1e-3)
    assert found.T == pytest.approx((found.T1 + found.T2 - found.T3).real)
    assert sorted([-1 / found.T1, -1 / found.T2]) == pytest.approx(sorted(np.linalg.eigvals(A[2:, 2:])))


def test_functions_of_python_control_take_the_system() -> None:
    linear = nw.published("yasukawa2015_kvlcc2").linearize(u=1.179)
    whole, one = linear.state_space(), linear.tf("rudder", "r")
    s = 0.1j
    np.testing.assert_allclose(one(s), whole["r", "rudder"](s), rtol=1e-9)
    np.testing.assert_allclose(linear.frequency_response([0.1], input="rudder", output="r").complex, one(s), rtol=1e-9)
    np.testing.assert_allclose(linear.ctrb(), control.ctrb(linear.A, linear.B))
    with pytest.raises(AttributeError, match="has no 'obsv'; write matrices"):
        linear.obsv()
