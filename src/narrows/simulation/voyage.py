"""One voyage: where, when and on which side the ship grounds, and how she got there."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from narrows.compile import Limits
from narrows.errors import InputError, check_choice, shown
from narrows.model.model import Model
from narrows.quantities.names import MOTION
from narrows.ship.actuators import RUDDER
from narrows.simulation import outcome as end
from narrows.simulation.course import Course, course_of
from narrows.simulation.inputs import MOST_ROWS, Schedule, Stretch, check_steps, check_times, finite_numbers, stretches
from narrows.simulation.integrate import METHODS, Rate, Row, State
from narrows.simulation.netcdf import save_netcdf
from narrows.simulation.outcome import Outcome
from narrows.simulation.ship import Outline, SimulatedShip
from narrows.simulation.steering import Helm, steered
from narrows.simulation.step_error import track_error
from narrows.simulation.validity import beyond_envelope

if TYPE_CHECKING:
    import xarray

    from narrows.waterway.waterway import Waterway

LIMITS = Limits()
COARSE = 0.02
"""Of the beam, by which a track may be off without a word."""
CONTACT = 1e-6
"""A gap that counts as closed [m]."""


@dataclass(frozen=True)
class Voyage:
    """A voyage, row by row, and how it ended.

    Parameters
    ----------
    t : array (times,) [s]
        Time.
    x, y : array (times,) [m]
        Midship in the canal.
    psi : array (times,) [rad]
        Heading.
    u, v : array (times,) [m/s]
        Surge and sway velocity.
    r : array (times,) [rad/s]
        Yaw rate.
    rudder : array (times,) [rad]
        Angle of the rudder.
    outcome : Outcome
        How it ended.
    """

    t: np.ndarray
    x: np.ndarray
    y: np.ndarray
    psi: np.ndarray
    u: np.ndarray
    v: np.ndarray
    r: np.ndarray
    rudder: np.ndarray
    outcome: Outcome

    def dataset(self) -> "xarray.Dataset":
        """Return the voyage as an xarray Dataset with units."""
        import xarray

        units = {"x": "m", "y": "m", "psi": "rad", "u": "m/s", "v": "m/s", "r": "rad/s", "rudder": "rad"}
        data = {
            name: ("t", getattr(self, name), {"units": unit, "long_name": _long_name(name)})
            for name, unit in units.items()
        }
        attributes = {"outcome": self.outcome.kind, "side": self.outcome.side or "", "says": self.outcome.sentence}
        return xarray.Dataset(data, coords={"t": ("t", self.t, {"units": "s", "long_name": "time"})}, attrs=attributes)

    def save(self, path: str | Path) -> None:
        """Write the voyage as NetCDF.

        Parameters
        ----------
        path : str or Path
            Where to.

        Raises
        ------
        InputError
            Where the file cannot be written.
        """
        save_netcdf(self.dataset(), path)


def _long_name(name: str) -> str:
    return {"psi": "heading", "rudder": "rudder angle"}.get(name) or MOTION[name].meaning


def simulate(
    model: Model, y: float = 0.0, u: float = 1.0, duration: float = 60.0, dt: float = 0.02, *,
    x: float = 0.0, psi: float = 0.0, v: float = 0.0, r: float = 0.0,
    X: Schedule = 0.0, Y: Schedule = 0.0, N: Schedule = 0.0, rudder: float = 0.0,
    surge: str = "held", surge_inertia: float | None = None, coriolis: bool = False,
    contact: str | Outline = "corners", method: str = "rk4", at: Sequence[float] | None = None,
    waterway: "Waterway | None" = None, helm: Helm | None = None,
) -> Voyage:  # fmt: skip
    """Simulate one voyage until the ship grounds or the time is up.

    Parameters
    ----------
    model : Model
        The ship in her canal.
    y : float [m]
        Start to starboard of the centreline.
    u : float [m/s]
        Surge velocity at the start.
    duration : float [s]
        Longest time.
    dt : float [s]
        Step, and the spacing of the output unless ``at`` is given.
    x : float [m]
        Start along the canal.
    psi : float [rad]
        Heading at the start.
    v : float [m/s]
        Sway velocity at the start.
    r : float [rad/s]
        Yaw rate at the start.
    X, Y : float or pairs [N]
        Surge and sway force from elsewhere: a constant, or (time, value) pairs, each held until the next.
    N : float or pairs [N m]
        Yaw moment from elsewhere, likewise.
    rudder : float [rad]
        Its angle at the start, for models with terms of the rudder; positive where it turns the bow to starboard.
        It is held unless there is a helm.
    surge : str
        ``held``: the speed stays; ``free``: it is integrated.
    surge_inertia : float [kg], optional
        Mass in surge with its added mass, for ``free`` where a_udot was not identifiable.
    coriolis : bool
        Add the rigid body's Coriolis force; the fitted damping at one speed holds it already.
    contact : str or points [m]
        ``corners`` of the hull's rectangle, ``midship`` as in the paper, or an outline of (forward, starboard);
        ``none`` in open water.
    method : str
        ``rk4``, or ``dop853`` as the check on it.
    at : sequence of float [s], optional
        Output times.
    waterway : Waterway, optional
        Where she sails instead of the model's own canal: x is then along its line, y to starboard of it, psi to it,
        u and v through the water; the voyage ends where it ends.
    helm : Helm, optional
        Gives an order to the rudder each step, which the model's steering gear follows.

    Returns
    -------
    Voyage
        Columns, and the outcome with its sentence.

    Raises
    ------
    InputError
        Where an input is not finite, touches a bank at the start, surge lacks an inertia, or a helm has no rudder.
    """
    check_choice("method", method, METHODS)
    _check_waterway(waterway)
    x, y, psi, u, v, r, rudder = finite_numbers(x=x, y=y, psi=psi, u=u, v=v, r=r, rudder=rudder).values()
    output = None if at is None else check_times(at)
    longest, dt = check_steps(output[-1] if output else duration, dt, MOST_ROWS)
    _check_helm(model, helm, method)
    ship = SimulatedShip(model, surge, surge_inertia, coriolis, contact, rudder)
    if waterway is not None and not 0 <= x < waterway.line.length:
        raise InputError(f"x = {x:g} m is not on {waterway.name}, 0 to {waterway.line.length:.0f} m; start on it")
    course = course_of(ship, waterway)
    start = (x, y, math.cos(psi), math.sin(psi), u, v, r, rudder)
    _check_afloat(course, start)
    _check_forces(course, start)
    times = [0.0, *output] if output else _times(longest, dt)
    rows = _rows(course, start, times, stretches(X, Y, N, times[-1]), dt, method, helm)
    coarse = _coarse(course, rows, dt) if method == "rk4" else ""
    return _voyage(rows, ship, course, psi, times[-1], coarse)


def _rows(
    course: Course, start: State, times: list[float], pushes: list[Stretch], dt: float, method: str, helm: Helm | None
) -> list[Row]:
    def gap(state: State) -> float:
        """Metres to the bank, cut off where the model ends."""
        return min(course.gap(state), state[2] - course.widest) if _sane(state) else -math.inf

    rows = [(0.0, start)]
    gear = course.ship.model.configuration.gear
    for push in pushes:
        own = [push.start, *(t for t in times if push.start < t < push.stop), push.stop]
        rows += METHODS[method](steered(partial(_rate, course, push.forces), helm, gear), rows[-1][1], own, gap, dt)
        if rows[-1][0] < push.stop:
            break
    wanted = {*times, rows[-1][0]}
    return [row for row in rows if row[0] in wanted]


def _coarse(course: Course, rows: list[Row], dt: float) -> str:
    """Say where the time step was too long, as far as the steps themselves tell."""
    if not _sane(rows[-1][1]) or len(rows) < 2:
        return ""
    error = track_error(course.rate((0.0, 0.0, 0.0), 0.0), rows, dt)
    if error <= COARSE * course.ship.model.configuration.ship.beam:
        return ""
    return f"A time step of {dt:g} s is too long: her track is off by some {error:.2g} m; shorten it."


def _voyage(
    rows: list[Row], ship: SimulatedShip, course: Course, psi: float, stop: float, coarse: str
) -> Voyage:  # fmt: skip
    t, x, y, c, s, u, v, r, rudder = np.array([(t, *state) for t, state in rows]).T
    # Whole turns of the start are kept, and those of a turning circle counted.
    heading = np.unwrap(np.arctan2(s, c)) + (psi - math.atan2(math.sin(psi), math.cos(psi)))
    columns = {"t": t, "x": x, "y": y, "psi": heading, "u": u, "v": v, "r": r, "rudder": rudder}
    state = {name: float(column[-1]) for name, column in columns.items() if name not in ("t", "rudder")}
    kind, side = _kind_and_side(rows[-1], course, stop)
    beyond = beyond_envelope(ship.model.data_range, columns)
    return Voyage(**columns, outcome=Outcome(kind, float(t[-1]), float(x[-1] - x[0]), side, state, beyond, coarse))


def _kind_and_side(last: Row, course: Course, stop: float) -> tuple[str, str | None]:
    t, state = last
    if course.bank_gap(state) <= CONTACT:
        return end.GROUNDED, "starboard" if course.lean(state) > 0 else "port"
    if state[2] <= course.widest + CONTACT:
        return end.LEFT_VALIDITY, None
    # What ends before its time, neither aground nor across nor at the end, has run out of sane numbers.
    done = t >= stop or course.gap(state) <= CONTACT
    return (end.AFLOAT if done and _sane(state) else end.DIVERGED), None


def _sane(state: State) -> bool:
    *_, u, v, r, _ = state
    return abs(u) < LIMITS.speed and abs(v) < LIMITS.speed and abs(r) < LIMITS.rate


def _check_waterway(waterway: object) -> None:
    if waterway is not None and not hasattr(waterway, "line"):
        raise InputError(f"waterway = {shown(waterway)} is none; read one with read_waterway")


def _check_helm(model: Model, helm: Helm | None, method: str) -> None:
    if helm is not None and RUDDER not in model.terms.actuators:
        raise InputError("this model has no terms of a rudder, so no helm steers her; add them as docs/rudder.md shows")
    if helm is not None and method != "rk4":
        raise InputError(f"method {method!r} takes no orders from a helm; leave it at rk4")


def _check_afloat(course: Course, start: State) -> None:
    _, y, c, s, *_ = start
    if c <= course.widest:
        raise InputError(f"psi = {math.degrees(math.atan2(s, c)):.1f} deg lies across the canal; start within 85 deg")
    gap = course.bank_gap(start)
    if gap <= 0:
        raise InputError(f"y = {y:g} m starts with the hull {-gap:.3g} m into the bank; start nearer the centreline")


def _check_forces(course: Course, start: State) -> None:
    if not all(map(math.isfinite, _rate(course, (0.0, 0.0, 0.0), 0.0)(start))):
        u, v, r = start[4:7]
        raise InputError(f"the forces of this model are not finite at u = {u:g}, v = {v:g}, r = {r:g}; start otherwise")


def _rate(course: Course, forces: tuple[float, float, float], turning: float) -> Rate:
    """The right-hand side, not a number where it divides by nothing or runs out of numbers."""
    rate = course.rate(forces, turning)

    def safe(state: State) -> State:
        try:
            return rate(state)
        except ArithmeticError:
            return (math.nan,) * len(state)

    return safe


def _times(duration: float, dt: float) -> list[float]:
    steps = max(1, math.ceil(duration / dt - 1e-9))
    return [min(i * dt, duration) for i in range(steps + 1)]
