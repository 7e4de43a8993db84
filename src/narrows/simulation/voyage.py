"""One voyage: where, when and on which side the ship grounds, and how she got there."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from narrows.compile import Limits
from narrows.errors import InputError, did_you_mean
from narrows.model import Model
from narrows.simulation import outcome as end
from narrows.simulation.inputs import Schedule, Stretch, stretches
from narrows.simulation.integrate import METHODS, Rate, Row, State
from narrows.simulation.netcdf import save_netcdf
from narrows.simulation.outcome import Outcome
from narrows.simulation.ship import Outline, SimulatedShip
from narrows.simulation.validity import beyond_envelope
from narrows.vocabulary import MOTION

if TYPE_CHECKING:
    import xarray

LIMITS = Limits()
WIDEST = math.cos(LIMITS.heading)
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
    outcome: Outcome

    def dataset(self) -> "xarray.Dataset":
        """Return the voyage as an xarray Dataset with units."""
        import xarray

        units = {"x": "m", "y": "m", "psi": "rad", "u": "m/s", "v": "m/s", "r": "rad/s"}
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
    return "heading" if name == "psi" else MOTION[name].meaning


def simulate(
    model: Model, y: float = 0.0, u: float = 1.0, duration: float = 60.0, dt: float = 0.02, *,
    x: float = 0.0, psi: float = 0.0, v: float = 0.0, r: float = 0.0,
    X: Schedule = 0.0, Y: Schedule = 0.0, N: Schedule = 0.0,
    surge: str = "held", surge_inertia: float | None = None, coriolis: bool = False,
    contact: str | Outline = "corners", method: str = "rk4", at: Sequence[float] | None = None,
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
    surge : str
        ``held``: the speed stays; ``free``: it is integrated.
    surge_inertia : float [kg], optional
        Mass in surge with its added mass, for ``free`` where a_udot was not identifiable.
    coriolis : bool
        Add the rigid body's Coriolis force; the fitted damping at one speed holds it already.
    contact : str or points [m]
        ``corners`` of the hull's rectangle, ``midship`` as in the paper, or an outline of (forward, starboard).
    method : str
        ``rk4``, or ``dop853`` as the check on it.
    at : sequence of float [s], optional
        Output times.

    Returns
    -------
    Voyage
        Columns, and the outcome with its sentence.

    Raises
    ------
    InputError
        Where an input is not finite, touches a bank at the start, or surge lacks an inertia.
    """
    if method not in METHODS:
        raise InputError(f"method {method!r} is unknown{did_you_mean(method, METHODS)}")
    _check_finite(x=x, y=y, psi=psi, u=u, v=v, r=r, duration=duration, dt=dt)
    ship = SimulatedShip(model, surge, surge_inertia, coriolis, contact)
    start = (x, y, math.cos(psi), math.sin(psi), u, v, r)
    _check_afloat(ship, start)
    times = _times(duration, dt, at)
    rows = _rows(ship, start, times, stretches(X, Y, N, times[-1]), dt, method)
    return _voyage(rows, ship, psi, times[-1])


def _rows(
    ship: SimulatedShip, start: State, times: list[float], pushes: list[Stretch], dt: float, method: str
) -> list[Row]:
    room, constants = ship.program.gap, ship.constants

    def gap(state: State) -> float:
        """Metres to the bank, cut off where the model ends."""
        _, y, c, s, *_ = state
        return min(room(y, c, s, *constants), c - WIDEST) if _sane(state) else -math.inf

    rows = [(0.0, start)]
    for push in pushes:
        own = [push.start, *(t for t in times if push.start < t < push.stop), push.stop]
        rows += METHODS[method](_rate(ship, push.forces), rows[-1][1], own, gap, dt)
        if rows[-1][0] < push.stop:
            break
    wanted = {*times, rows[-1][0]}
    return [row for row in rows if row[0] in wanted]


def _rate(ship: SimulatedShip, forces: tuple[float, float, float]) -> Rate:
    rhs, tail = ship.program.rhs, (*forces, *ship.constants)
    return lambda state: tuple(rhs(*state, *tail))


def _voyage(rows: list[Row], ship: SimulatedShip, psi: float, stop: float) -> Voyage:
    t, x, y, c, s, u, v, r = np.array([(t, *state) for t, state in rows]).T
    # Whole turns of the start are kept; the heading never turns far from there.
    heading = np.arctan2(s, c) + (psi - math.atan2(math.sin(psi), math.cos(psi)))
    columns = {"t": t, "x": x, "y": y, "psi": heading, "u": u, "v": v, "r": r}
    state = {name: float(column[-1]) for name, column in columns.items() if name != "t"}
    kind, side = _kind_and_side(rows[-1], ship, stop)
    beyond = beyond_envelope(ship.model.envelope, columns)
    return Voyage(**columns, outcome=Outcome(kind, float(t[-1]), float(x[-1] - x[0]), side, state, beyond))


def _kind_and_side(last: Row, ship: SimulatedShip, stop: float) -> tuple[str, str | None]:
    t, (_, y, c, s, *_) = last
    if ship.program.gap(y, c, s, *ship.constants) <= CONTACT:
        return end.GROUNDED, "starboard" if ship.program.lean(y, c, s, *ship.constants) > 0 else "port"
    if c <= WIDEST + CONTACT:
        return end.LEFT_VALIDITY, None
    # What ends before its time, neither aground nor across, has run out of sane numbers.
    return (end.AFLOAT if t >= stop and _sane(last[1]) else end.DIVERGED), None


def _sane(state: State) -> bool:
    *_, u, v, r = state
    return abs(u) < LIMITS.speed and abs(v) < LIMITS.speed and abs(r) < LIMITS.rate


def _check_finite(**values: float) -> None:
    for name, value in values.items():
        if not np.isfinite(value) or (name in ("duration", "dt") and value <= 0):
            what = "a positive, finite number" if name in ("duration", "dt") else "finite"
            raise InputError(f"{name} = {value} must be {what}")


def _check_afloat(ship: SimulatedShip, start: State) -> None:
    _, y, c, s, *_ = start
    if c <= WIDEST:
        raise InputError(f"psi = {math.degrees(math.atan2(s, c)):.1f} deg lies across the canal; start within 85 deg")
    gap = ship.program.gap(y, c, s, *ship.constants)
    if gap <= 0:
        raise InputError(f"y = {y:g} m starts with the hull {-gap:.3g} m into the bank; start nearer the centreline")


def _times(duration: float, dt: float, at: Sequence[float] | None) -> list[float]:
    if at is None:
        steps = max(1, math.ceil(duration / dt - 1e-9))
        return [min(i * dt, duration) for i in range(steps + 1)]
    times = [float(t) for t in at if t > 0]
    if not times or sorted(set(times)) != times:
        raise InputError("at: give rising output times after 0 s")
    return [0.0, *times]
