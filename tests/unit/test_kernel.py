"""Fleets: the same as voyages stepped one by one, contacts located, mirrored to the bit, whatever the cores."""

import math
from dataclasses import fields

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import narrows as nw
from narrows.compile import Fleet, Limits, Outcome, compiled
from narrows.compile.exponential import exponential_text
from narrows.compile.trace import ACCELERATIONS

DTC = nw.published("mikkelsen2025_dtc")
VALUES = {**DTC.configuration.values(), **DTC.coefficients, "surge_inertia": 300.0, "mass": 245.0}
PAPER = compiled(nw.PAPER)
COLUMNS = tuple(field.name for field in fields(Fleet) if field.name != "lane_steps")
ODD = ("side", "y", "psi", "v", "r")


def starts(count: int, seed: int = 0) -> dict[str, np.ndarray]:
    draw = np.random.default_rng(seed)
    tops = {"y": 2.5, "psi": 0.1, "v": 0.05, "r": 0.03}
    return {name: draw.uniform(-top, top, count) for name, top in tops.items()} | {"u": draw.uniform(0.7, 1.3, count)}


def stepped(program, values: dict, start: dict, dt: float, steps: int, pushes=(0.0, 0.0, 0.0)) -> np.ndarray:
    """The classical Runge-Kutta step in plain Python, on columns."""
    constants = program.constants(values)

    def rate(z: np.ndarray) -> np.ndarray:
        return np.array(np.broadcast_arrays(*program.rhs(*z, *pushes, 1.0, 0.0, 0.0, *constants))[:7])

    z = np.array([0 * start["y"], start["y"], np.cos(start["psi"]), np.sin(start["psi"]), *(start[n] for n in "uvr")])
    for _ in range(steps):
        k1 = rate(z)
        k2 = rate(z + dt / 2 * k1)
        k3 = rate(z + dt / 2 * k2)
        z = z + dt / 6 * (k1 + 2 * k2 + 2 * k3 + rate(z + dt * k3))
        z[2:4] *= 1.5 - 0.5 * (z[2] ** 2 + z[3] ** 2)
    return z


@pytest.mark.parametrize(
    ("table", "surge", "coriolis", "pushes"),
    [(nw.PAPER, "held", False, None), (nw.TAPERED, "free", True, {"X_in": 12.0, "Y_in": 0.4, "N_in": -0.2})],
)
def test_a_fleet_takes_the_steps_of_one_voyage(table, surge: str, coriolis: bool, pushes: dict | None) -> None:
    program, start = compiled(table, surge, coriolis), starts(150)
    given = {**VALUES, **(pushes or {})}
    end = program.fleet(given, **start, dt=0.05, duration=2.0)
    x, y, c, s, u, v, r = stepped(program, VALUES, start, 0.05, 40, tuple((pushes or {}).values()) or (0.0,) * 3)
    assert (end.steps[end.outcome == Outcome.AFLOAT] == 40).all()
    afloat = end.outcome == Outcome.AFLOAT
    assert afloat.sum() > 100
    for name, value in {"x": x, "y": y, "psi": np.arctan2(s, c), "u": u, "v": v, "r": r}.items():
        np.testing.assert_allclose(getattr(end, name)[afloat], value[afloat], rtol=1e-12, atol=1e-13, err_msg=name)


def test_contact_is_where_an_independent_solver_finds_it() -> None:
    """DOP853 on the forces of the terms themselves, away from the switch between the banks."""
    y = np.array([-2.2, -1.1, -0.3, 0.3, 0.7, 1.6, 2.2])
    end = PAPER.fleet(VALUES, y=y, u=1.0, dt=0.005, duration=60.0)
    for i, start in enumerate(y):
        t, (_, at_y, psi, v, r), x = grounding(start)
        assert end.outcome[i] == Outcome.GROUNDED
        assert end.time[i] == pytest.approx(t, abs=1e-6)
        assert end.x[i] == pytest.approx(x, abs=1e-6)
        assert (end.y[i], end.psi[i]) == pytest.approx((at_y, psi), abs=1e-6)
        assert (end.v[i], end.r[i]) == pytest.approx((v, r), abs=1e-6)
        assert end.side[i] == np.sign(at_y)


def grounding(y: float) -> tuple[float, np.ndarray, float]:
    ship, canal = DTC.configuration.ship, DTC.configuration.canal
    mass = np.array([[DTC.coefficients[f"{row}_{name}"] for name in ("vdot", "rdot")] for row in "bc"])

    def rate(_: float, z: np.ndarray) -> list[float]:
        _, y, psi, v, r = z
        force = DTC.forces(nw.Motion.at(psi, y=y, u=1.0, v=v, r=r))
        turning = np.linalg.solve(mass, [force["Y"], force["N"]])
        return [math.cos(psi) - v * math.sin(psi), math.sin(psi) + v * math.cos(psi), r, *turning]

    def gap(_: float, z: np.ndarray) -> float:
        reach = abs(z[1]) + ship.length / 2 * abs(math.sin(z[2])) + ship.beam / 2 * math.cos(z[2])
        return canal.width / 2 - reach

    gap.terminal = True
    done = solve_ivp(rate, (0, 60), [0, y, 0, 0, 0], "DOP853", events=gap, rtol=1e-10, atol=1e-12)
    return done.t[-1], done.y[:, -1], done.y[0, -1]


@pytest.mark.parametrize("contact", ["corners", "midship"])
def test_the_gap_is_closed_at_contact(contact: str) -> None:
    program = compiled(nw.PAPER, contact=contact)
    end = program.fleet(VALUES, y=np.linspace(0.35, 2.6, 40), psi=0.1, u=1.0, dt=0.02, duration=60.0)
    hit = end.outcome == Outcome.GROUNDED
    assert hit.sum() > 2
    gap = program.gap(end.y, np.cos(end.psi), np.sin(end.psi), *program.constants(VALUES))
    assert np.abs(gap[hit]).max() < (1e-6 if contact == "corners" else 7e-3)
    assert (gap[~hit] > 0).all()


def test_a_contact_is_found_in_a_few_steps() -> None:
    """Twins that sail as one keep every lane at work, so what is left over went into the search."""
    for y in np.linspace(0.4, 2.5, 12):
        end = PAPER.fleet(VALUES, y=np.full(64, y), u=1.0, dt=0.02, duration=60.0, workers=1)
        assert end.lane_steps / 64 - end.steps[0] <= 5


def test_an_outline_touches_with_its_points() -> None:
    """The rectangle's corners as points, and half of it cut off."""
    ship, start = DTC.configuration.ship, starts(200, seed=3)
    corners = [(f * ship.length / 2, a * ship.beam / 2) for f in (1, -1) for a in (1, -1)]
    outline = compiled(nw.PAPER, contact=corners)
    one, other = (program.fleet(VALUES, **start, dt=0.02, duration=40.0) for program in (PAPER, outline))
    np.testing.assert_array_equal(one.side, other.side)
    np.testing.assert_allclose(one.time, other.time, atol=1e-7)
    bow_only = compiled(nw.PAPER, contact=[(f, a) for f, a in corners if f > 0] + [(0.0, 0.0), (0.1, 0.0)])
    later = bow_only.fleet(VALUES, **start, dt=0.02, duration=40.0)
    assert (later.time >= other.time - 1e-7).all()
    assert (later.time > other.time + 1e-3).any()


def test_a_mirrored_fleet_is_the_mirror_to_the_bit() -> None:
    start = starts(500)
    mirrored = {name: -column if name in ODD else column for name, column in start.items()}
    one, other = (PAPER.fleet(VALUES, **s, dt=0.02, duration=30.0) for s in (start, mirrored))
    for name in COLUMNS:
        sign = -1 if name in ODD else 1
        np.testing.assert_array_equal(getattr(one, name), sign * getattr(other, name), err_msg=name)


def test_neither_cores_nor_company_change_a_voyage() -> None:
    start = starts(5000)
    one, two = (PAPER.fleet(VALUES, **start, dt=0.05, duration=30.0, workers=workers) for workers in (1, 2))
    few = PAPER.fleet(VALUES, **{n: c[4000:4003] for n, c in start.items()}, dt=0.05, duration=30.0)
    for name in COLUMNS:
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))
        np.testing.assert_array_equal(getattr(one, name)[4000:4003], getattr(few, name))


def test_values_may_differ_from_vessel_to_vessel() -> None:
    start, count, draw = starts(200), 200, np.random.default_rng(5)
    varied = {"b_v": draw.uniform(80, 120, count), "width": draw.uniform(6.5, 8, count)}
    dt = draw.uniform(0.02, 0.05, count)
    many = PAPER.fleet({**VALUES, **varied}, **start, dt=dt, duration=20.0)
    for i in (0, 77, 199):
        own = VALUES | {name: column[i] for name, column in varied.items()}
        alone = PAPER.fleet(own, **{name: column[i] for name, column in start.items()}, dt=dt[i], duration=20.0)
        for name in COLUMNS:
            assert getattr(many, name)[i] == pytest.approx(getattr(alone, name)[0], rel=1e-11, abs=1e-12)


def test_single_precision_is_near() -> None:
    y = np.linspace(0.3, 2.2, 100)
    double, single = (
        PAPER.fleet(VALUES, y=y, u=1.0, dt=0.02, duration=40.0, precision=precision)
        for precision in ("float64", "float32")
    )
    np.testing.assert_array_equal(single.outcome, double.outcome)
    np.testing.assert_array_equal(single.side, double.side)
    np.testing.assert_allclose(single.time, double.time, atol=1e-3)


class TestOutcomes:
    """How voyages end, beside the usual way."""

    def test_time_is_up(self) -> None:
        end = PAPER.fleet(VALUES, y=[0.5, 0.0], u=1.0, dt=0.02, duration=1.01)
        assert end.outcome.tolist() == [Outcome.AFLOAT] * 2
        assert end.steps.tolist() == [51, 51]
        np.testing.assert_allclose(end.time, 1.02)
        assert end.side.tolist() == [0, 0]

    def test_on_the_centreline_nothing_happens(self) -> None:
        end = PAPER.fleet(VALUES, y=0.0, u=1.0, dt=0.02, duration=40.0)
        assert (end.y[0], end.psi[0], end.outcome[0]) == (0.0, 0.0, Outcome.AFLOAT)
        assert end.x[0] == pytest.approx(40.0)

    def test_before_they_begin(self) -> None:
        end = PAPER.fleet(VALUES, y=[3.3, -3.3, 0.0, 0.5], psi=[0, 0, 1.5, 0], u=1.0, dt=0.02, duration=0.5)
        assert end.outcome.tolist() == [Outcome.GROUNDED, Outcome.GROUNDED, Outcome.OUTSIDE, Outcome.AFLOAT]
        assert end.side.tolist() == [1, -1, 0, 0]
        assert end.time.tolist() == [0.0, 0.0, 0.0, 0.5]
        assert PAPER.fleet(VALUES, y=0.5, u=1.0, dt=0.02, duration=0.0).time.tolist() == [0.0]

    def test_across_the_canal(self) -> None:
        wide = {**VALUES, "width": 40.0}
        end = PAPER.fleet(wide, y=0.0, r=0.5, u=0.1, dt=0.02, duration=400.0, limits=Limits(heading=0.4))
        assert end.outcome[0] == Outcome.OUTSIDE
        assert 0.4 < end.psi[0] < 0.42

    def test_beyond_any_sense(self) -> None:
        wild = {**VALUES, "width": 400.0, "b_v": -1e5}
        end = PAPER.fleet(wild, y=[0.0, 1.0], v=[0.01, 0.0], u=1.0, dt=0.02, duration=400.0)
        assert end.outcome.tolist() == [Outcome.DIVERGED] * 2
        assert np.isfinite([end.y, end.v, end.r, end.time]).all()

    def test_a_nan_is_noticed(self) -> None:
        """A kernel compiled without regard for NaN would sail on."""
        wild = {**VALUES, "c_vv": -1e300}
        end = PAPER.fleet(wild, y=np.full(70, 0.5), v=0.1, u=1.0, dt=0.5, duration=40.0)
        assert (end.outcome == Outcome.DIVERGED).all()

    def test_each_has_its_sentence(self) -> None:
        assert len({outcome.sentence for outcome in Outcome}) == len(Outcome)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"y": [0.1, math.nan]}, "y of vessel 1 is not a finite number"),
        ({"dt": 0.0}, "dt and duration"),
        ({"duration": math.inf}, "dt and duration"),
        ({"y": [0.1, 0.2], "psi": [0.0, 0.0, 0.0]}, "do not match"),
        ({"values": {**VALUES, "b_v": np.ones(3)}, "y": [0.1, 0.2]}, "do not match"),
        ({"values": {**VALUES, "width": None}}, "need width"),
        ({"precision": "float32", "dt": 1e-8}, "single precision"),
    ],
)
def test_what_cannot_sail_is_refused(change: dict, words: str) -> None:
    given = {"values": VALUES, "y": 0.5, "u": 1.0, "dt": 0.02, "duration": 10.0} | change
    with pytest.raises(nw.InputError, match=words):
        PAPER.fleet(**given)


def test_an_empty_fleet_comes_back_empty() -> None:
    assert len(PAPER.fleet(VALUES, y=np.empty(0), u=1.0, dt=0.02, duration=10.0).time) == 0


@pytest.mark.parametrize(("precision", "accuracy"), [("float64", 3e-16), ("float32", 2e-7)])
def test_the_exponential_is_good_to_the_last_place(precision: str, accuracy: float) -> None:
    import numba

    scope = {"np": np, "real": getattr(np, precision), "jit": numba.njit(fastmath={"nsz", "contract"})}
    exec(exponential_text(precision), scope)
    top = 80.0 if precision == "float32" else 700.0
    for x in np.random.default_rng(0).uniform(-top, top, 2000).astype(precision):
        assert scope["exp"](x) == pytest.approx(math.exp(x), rel=accuracy)


def test_the_state_has_its_accelerations() -> None:
    assert list(ACCELERATIONS.values()) == ["udot", "vdot", "rdot"]
