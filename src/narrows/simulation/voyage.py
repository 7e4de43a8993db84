"""One voyage: where, when and on which side the ship grounds, and how it got there."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.codegen.free_motion import INPUTS, STATE
from narrows.codegen.kernels import event
from narrows.codegen.shapes import OPEN
from narrows.errors import InputError, did_you_mean
from narrows.model.model import Model
from narrows.quantities.names import MOTION
from narrows.simulation import outcome as end
from narrows.simulation.channel import Channel, along_waterway, straight_channel
from narrows.simulation.inputs import (
    MOST_ROWS,
    Schedule,
    Stretch,
    check_steps,
    check_times,
    check_waterway,
    finite_numbers,
    stretches,
)
from narrows.simulation.march import March, Row, near_the_bank
from narrows.simulation.netcdf import save_netcdf
from narrows.simulation.outcome import Outcome
from narrows.simulation.ship import Points, SimulatedShip
from narrows.simulation.steering import Steering, steering_of
from narrows.simulation.step_error import track_error
from narrows.simulation.validity import beyond_envelope

if TYPE_CHECKING:
    import xarray

    from narrows.waterway.waterway import Waterway

POSE = ("x", "y", "psi", "u", "v", "r")
LONGEST = 60.0
"""Of a voyage [s] where nothing is said of it."""
COARSE = 0.02
"""Of the beam, by which a track may be off without a word."""
CONTACT = 1e-6
"""A room that counts as closed [m]."""


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
        attributes = {
            "outcome": self.outcome.kind, "side": self.outcome.side or "", "summary": self.outcome.sentence,
        }  # fmt: skip
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
    model: Model, y: float = 0.0, u: float = 1.0, duration: float | None = None, dt: float = 0.02, *,
    x: float = 0.0, psi: float = 0.0, v: float = 0.0, r: float = 0.0,
    X: Schedule = 0.0, Y: Schedule = 0.0, N: Schedule = 0.0, rudder: float = 0.0,
    surge: str = "held", surge_inertia: float | None = None, coriolis: bool = False,
    contact: str | Points = "corners", at: Sequence[float] | None = None,
    waterway: "Waterway | None" = None, controller: Any = None, **positions: float,
) -> Voyage:  # fmt: skip
    """Simulate one voyage until the ship grounds or the time is up.

    The classical Runge-Kutta method of order 4 in steps of ``dt``; a contact is located inside its step.

    Parameters
    ----------
    model : Model
        The ship in its canal.
    y : float [m]
        Start to starboard of the centreline.
    u : float [m/s]
        Surge velocity at the start.
    duration : float [s], optional
        Longest time: 60 s, or the last of ``at``, unless given.
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
        It is held unless a controller moves it.
    surge : str
        ``held``: the speed stays; ``free``: it is integrated.
    surge_inertia : float [kg], optional
        Mass in surge with its added mass, for ``free`` where a_udot was not identifiable.
    coriolis : bool
        Add the rigid body's Coriolis force; the fitted damping at one speed holds it already.
    contact : str or points [m]
        ``corners`` of the hull's rectangle, ``midship`` as in the paper, or an outline of (forward, starboard);
        ``none`` in open water.
    at : sequence of float [s], optional
        Output times; they do not change the voyage.
    waterway : Waterway, optional
        Where it sails instead of the model's own canal: x is then along its line, y to starboard of it, psi to it,
        u and v through the water; the voyage ends where it ends.
    controller : ControlLaw or Controller, optional
        Gives orders each step, which the model's steering gear follows.
    **positions : float
        Of other actuators at the start, by their names: revolutions [1/s], or one of the model's own.

    Returns
    -------
    Voyage
        Columns, and the outcome with its sentence.

    Raises
    ------
    InputError
        Where an input is not finite, touches a bank at the start, surge lacks an inertia, or a controller has no
        rudder.
    """
    check_waterway(waterway)
    numbers = finite_numbers(x=x, y=y, psi=psi, u=u, v=v, r=r, rudder=rudder, **positions)
    times = None if at is None else check_times(at, duration)
    longest = times[-1] if times else LONGEST
    duration, dt = check_steps(longest if duration is None else duration, dt, MOST_ROWS)
    ship = SimulatedShip(model, surge, surge_inertia, coriolis, contact)
    pushes = stretches(X, Y, N, duration)
    check_positions(positions, ship)
    steering = steering_of(controller, ship.actuators)
    march, start = _march(ship, steering, numbers, waterway, any(any(push.forces) for push in pushes))
    rows, fate = _rows(march, start, pushes, dt)
    return _Log(ship, march, rows, fate, float(psi), float(rudder)).voyage(times, dt)


def check_positions(positions: Mapping[str, float], ship: SimulatedShip) -> None:
    """Raise where a position is of no actuator of the model (ours).

    Parameters
    ----------
    positions : mapping of str to float
        By name.
    ship : SimulatedShip
        The ship.

    Raises
    ------
    InputError
        Names the first.
    """
    known = [own.name for own in ship.actuators]
    for name in positions:
        if name not in known:
            hint = did_you_mean(name, known) if known else "; it has none"
            raise InputError(f"a voyage knows no {name!r}, and no actuator of the model is called that{hint}")


def _march(
    ship: SimulatedShip, steering: Steering | None, numbers: dict[str, float], waterway: "Waterway | None", pushed: bool
) -> tuple[March, tuple[float, ...]]:
    """The lines and every number that they ask for, and what is kept from step to step, at the start."""
    values = ship.values(**{name: number for name, number in numbers.items() if name not in POSE})
    channel = _channel(ship, values, waterway, numbers["x"])
    system = ship.system(waterway is not None, steering.law if steering else None, "until" if pushed else "never")
    inputs = {**values, **system.constants(values), **channel.inputs, **(steering.parameters if steering else {})}
    inputs |= {**dict.fromkeys(INPUTS.values(), 0.0), "push_end": math.inf}
    order = steering.asked.begin() if steering and steering.asked else None
    march = March(system.scalar, system.choices, inputs, channel, near_the_bank(values), order)
    start = _start(ship, system.choices.kept, steering, numbers)
    _check_afloat(march, start)
    return march, start


def _channel(ship: SimulatedShip, values: dict[str, Any], waterway: "Waterway | None", x: float) -> Channel:
    if waterway is None:
        return straight_channel(values, ship.shape)
    if not 0 <= x < waterway.line.length:
        raise InputError(f"x = {x:g} m is not on {waterway.name}, 0 to {waterway.line.length:.0f} m; start on it")
    return along_waterway(waterway, ship.model, ship.shape)


def _start(
    ship: SimulatedShip, kept: tuple[str, ...], steering: Steering | None, numbers: dict[str, float]
) -> tuple[float, ...]:
    psi = numbers["psi"]
    state = {**numbers, "t": 0.0, "cos_psi": math.cos(psi), "sin_psi": math.sin(psi)}
    at_rest = ship.values()
    state |= {own.name: state.get(own.name, float(at_rest.get(own.name) or 0.0)) for own in ship.actuators}
    memory = steering.memory(state) if steering else {}
    return tuple(float({**state, **memory}[name]) for name in kept)


def _check_afloat(march: March, start: tuple[float, ...]) -> None:
    _, y, cosine, sine, *_ = start
    if cosine <= march.inputs["least_cos"]:
        heading = math.degrees(math.atan2(sine, cosine))
        raise InputError(f"psi = {heading:.1f} deg lies across the canal; start within 85 deg")
    room, _ = march.room(start)
    if room < 0 or (room == 0 and start[0] != march.channel.start):
        raise InputError(f"y = {y:g} m starts with the hull {-room:.3g} m into the bank; start nearer the centreline")
    if not all(map(math.isfinite, march.stepped(start, 0.0)[0])):
        u, v, r = start[4:7]
        raise InputError(f"the forces of this model are not finite at u = {u:g}, v = {v:g}, r = {r:g}; start otherwise")


def _rows(march: March, start: tuple[float, ...], pushes: list[Stretch], dt: float) -> tuple[list[Row], int]:
    """Every step of the voyage, cut where the forces from outside jump, and how it ended."""
    rows = [Row(0.0, start)]
    for push in pushes:
        march.set(**dict(zip(INPUTS.values(), push.forces, strict=True)))
        ended = march.sail(rows, push.stop, dt)
        if ended is not None:
            return rows, ended.fate
    return rows, event.FINISHED


@dataclass(frozen=True)
class _Log:
    """A march as it was sailed, to be told as a voyage."""

    ship: SimulatedShip
    march: March
    rows: list[Row]
    fate: int
    psi: float
    rudder: float

    def voyage(self, at: list[float] | None, dt: float) -> Voyage:
        """The voyage at every step, or at times of one's own and at its end."""
        last = self.rows[-1]
        whole = [row for row in self.rows if row.whole]
        shown = whole if at is None else [*self.march.dense(self.rows, [t for t in (0.0, *at) if t < last.t]), last]
        seen = sorted({row.t: row for row in (*self.rows, *shown)}.values(), key=lambda row: row.t)
        heading = dict(zip((row.t for row in seen), self._headings(seen), strict=True))
        columns = self._columns(shown) | {"psi": np.array([heading[row.t] for row in shown])}
        everything = self._columns(self.rows) | {"psi": self._headings(self.rows)}
        return Voyage(**columns, outcome=self._outcome(everything, dt))

    def _headings(self, rows: list[Row]) -> np.ndarray:
        """Whole turns of the start are kept, and those of a turning circle counted."""
        cosine, sine = np.array([row.state[2:4] for row in rows]).T
        turns = self.psi - math.atan2(math.sin(self.psi), math.cos(self.psi))
        return np.asarray(np.unwrap(np.arctan2(sine, cosine)) + turns)

    def _columns(self, rows: list[Row]) -> dict[str, np.ndarray]:
        kept = self.march.choices.kept
        table = np.array([row.state for row in rows])
        columns = {name: table[:, kept.index(name)] for name in ("x", "y", "u", "v", "r")}
        moved = table[:, kept.index("rudder")] if "rudder" in kept else np.full(len(rows), self.rudder)
        return {"t": np.array([row.t for row in rows]), **columns, "rudder": moved}

    def _outcome(self, columns: dict[str, np.ndarray], dt: float) -> Outcome:
        last = {name: float(column[-1]) for name, column in columns.items() if name != "rudder"}
        kind, side = self._kind_and_side(self.rows[-1].state)
        model = self.ship.model
        bank = () if self.ship.shape == OPEN or not model.bank_note else (model.bank_note,)
        notes = (*bank, *beyond_envelope(model.data_range, columns), *self._coarse(dt))
        state = {name: last[name] for name in ("x", "y", "psi", "u", "v", "r")}
        return Outcome(kind, last["t"], last["x"] - float(columns["x"][0]), side, state, notes)

    def _kind_and_side(self, state: tuple[float, ...]) -> tuple[str, str | None]:
        if self.fate == event.FINISHED:
            return end.AFLOAT, None
        if self.fate == event.LOST:
            return end.DIVERGED, None
        inputs, near = self.march.inputs, CONTACT
        if state[STATE.index("cos_psi")] - inputs["least_cos"] <= near:
            return end.LEFT_VALIDITY, None
        if self.march.channel.length - state[0] <= near:
            return end.LEFT_WATERWAY, end.END
        if state[0] - self.march.channel.start <= near:
            return end.LEFT_WATERWAY, end.BEGINNING
        return end.GROUNDED, "starboard" if self.march.room(state)[1] > 0 else "port"

    def _coarse(self, dt: float) -> tuple[str, ...]:
        """Say where the time step was too long, as far as the steps themselves tell."""
        if self.fate == event.LOST:
            return ()
        error = track_error(self.march, self.rows, dt)
        if not error > COARSE * self.ship.model.configuration.ship.beam:
            return ()
        return (f"A time step of {dt:g} s is too long: the track is off by some {error:.2g} m; shorten it.",)
