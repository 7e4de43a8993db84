"""Faults of a ship's sensors, each with one number: what a grid of readings is where the fault has a size."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from narrows.logbook.filtering.predicted_signals import RUDDER
from narrows.logbook.filtering.record_grid import Readings, RecordGrid
from narrows.logbook.settings import MOST_ANGLE
from narrows.logbook.ship_record import SIGNALS, TURNING, ShipRecord, Signal
from narrows.quantities.names import KNOT

POSITION = ("x", "y")
JUMPING = ("x", "y", "psi")  # signals that a reset moves
DEGREES = np.pi / 180


class FaultKind(NamedTuple):
    """A kind of fault."""

    sentence: str  # With the signal, the size with its error, and the time
    remedy: str


FAULTS = {
    "zero": FaultKind("{name} reads {size} {unit} too much", "correct its zero"),
    "gain": FaultKind("{name} truly is {size} times what is recorded", "check its unit, its sign and its calibration"),
    "delay": FaultKind("{name} is recorded {size} s late", "take the delay out: [late] {column} = {value:.2g}"),
    "antenna": FaultKind(
        "the position is that of a point {size} m forward of where the antenna is said to be",
        "give the antenna's place, forward and to starboard of midship",
    ),
    "step": FaultKind(
        "{name} jumps by {size} {unit} at t = {at:.6g} s",
        "a receiver, a compass or the clock was reset: begin another record there",
    ),
}


class Fault(NamedTuple):
    """A fault of one record."""

    kind: str  # One of FAULTS
    signal: str
    mended: Callable[[float], RecordGrid]  # The record without a fault of a size
    scale: float = 1.0  # A small size
    tries: int = 1  # Places among which this one was chosen
    at: float = np.nan  # Time of a step [s]


def faults_of(grid: RecordGrid, normalised: dict[str, np.ndarray]) -> Iterator[Fault]:
    """Yield the faults that a record may have; a step where the normalised innovations of a signal are largest."""
    for name, read in grid.readings.items():
        if name != "x":  # Nothing fixes where x begins.
            yield Fault("zero", name, partial(_shifted, grid, name, np.ones(len(read.values))), _small(name))
            if name not in (*TURNING, *POSITION):  # Neither angles that go round nor places by satellite have a gain.
                yield Fault("gain", name, partial(_scaled, grid, name))
        if name not in POSITION:
            yield Fault("delay", name, partial(_late, grid, (name,)))
        if name in JUMPING and len(read.values) > 2:
            t = grid.times_of(read)
            place = 1 + int(np.argmax(np.abs(normalised[name][1:])))
            after = np.where(np.arange(len(t)) >= place, 1.0, 0.0)
            yield Fault("step", name, partial(_shifted, grid, name, after), _small(name), len(t), float(t[place]))
    if grid.readings.keys() >= set(POSITION):
        yield Fault("delay", "x", partial(_late, grid, POSITION))
        yield Fault("antenna", "x", partial(_from_antenna, grid))
    if RUDDER in grid.positions:
        angle = grid.positions[RUDDER]
        yield Fault("zero", RUDDER, partial(_steered, grid, -np.ones(len(angle))), DEGREES)
        yield Fault("gain", RUDDER, partial(_steered, grid, angle))
        yield Fault("delay", RUDDER, partial(_steered, grid, np.gradient(angle, grid.times)))


def _small(name: str) -> float:
    """Size of a small zero or step, for slopes."""
    return {"rad": DEGREES, "rad/s": 0.01 * DEGREES}.get(SIGNALS[name].unit, 0.1)


def _read(grid: RecordGrid, name: str, read: Readings) -> RecordGrid:
    return replace(grid, readings={**grid.readings, name: read})


def _shifted(grid: RecordGrid, name: str, where: np.ndarray, size: float) -> RecordGrid:
    read = grid.readings[name]
    return _read(grid, name, replace(read, values=read.values - size * where))


def _scaled(grid: RecordGrid, name: str, size: float) -> RecordGrid:
    return _read(grid, name, replace(grid.readings[name], gain=1.0 - size))


def _late(grid: RecordGrid, names: Sequence[str], delay: float) -> RecordGrid:
    for name in names:
        read = grid.readings[name]
        grid = _read(grid, name, replace(read, share=read.share - delay / grid.step))
    return grid


def _from_antenna(grid: RecordGrid, forward: float) -> RecordGrid:
    ahead, starboard = grid.record.antenna
    return replace(grid, record=replace(grid.record, antenna=(ahead + forward, starboard)))


def _steered(grid: RecordGrid, change: np.ndarray, size: float) -> RecordGrid:
    return replace(grid, positions={**grid.positions, RUDDER: grid.positions[RUDDER] + size * change})


class Misreading(NamedTuple):
    """Another way to read signals: another sign, unit or axis."""

    signals: tuple[str, ...]
    sentence: str
    remedy: str
    reread: Callable[[ShipRecord], ShipRecord]
    shrunk: float  # Logarithm of how many times smaller a reading becomes: the Jacobian of the likelihood
    least: float = 0.0  # Size that some recorded value must reach

    def possible(self, record: ShipRecord) -> bool:
        """Return whether the signals are there and may be read so."""
        return all(
            name in record and np.abs(record[name].values).max(initial=0.0) >= self.least for name in self.signals
        )


def _times_as_much(factor: float, *names: str, remedy: str, least: float = 0.0) -> Misreading:
    def reread(record: ShipRecord) -> ShipRecord:
        return record.with_signals(**{name: Signal(record[name].t, factor * record[name].values) for name in names})

    words = "counts the other way" if factor == -1 else f"is {1 / factor:.4g} times what it should be"
    return Misreading(names, f"{' and '.join(names)} {words}", remedy, reread, -float(np.log(abs(factor))), least)


def _turned(by: complex, remedy: str) -> Misreading:
    names = ("u_ground", "v_ground")

    def reread(record: ShipRecord) -> ShipRecord:
        t = record["u_ground"].t
        velocity = record["u_ground"].values + 1j * record["v_ground"].at(t)
        velocity = velocity * np.exp(by * record["psi"].at(t))
        known = np.isfinite(velocity)
        return record.with_signals(
            u_ground=Signal(t[known], velocity[known].real), v_ground=Signal(t[known], velocity[known].imag)
        )

    return Misreading((*names, "psi"), "u_ground and v_ground are along other axes", remedy, reread, 0.0)


def _port(name: str) -> Misreading:
    return _times_as_much(-1.0, name, remedy=f'turn its sign ([positive] {name} = "port")')


MISREADINGS = (
    *(_port(name) for name in (RUDDER, "psi", "r", "y", "v", "v_ground", "course")),
    # Read as degrees a rudder nearly vanishes; where the model's rudder is too strong, that alone is more likely.
    _times_as_much(DEGREES, RUDDER, remedy="it looks like degrees: head it 'rudder [deg]'", least=MOST_ANGLE),
    *(_times_as_much(DEGREES, name, remedy=f"it looks like degrees: head it '{name} [deg]'")
      for name in ("psi", "course")),
    _times_as_much(1 / DEGREES, RUDDER, remedy="radians were read as degrees: give its unit"),
    _times_as_much(DEGREES, "r", remedy="r looks like degrees a second: give its unit"),
    _times_as_much(DEGREES / 60, "r", remedy="r looks like degrees a minute: give its unit"),
    _times_as_much(DEGREES, "psi", "r", remedy="psi looks like degrees and r like degrees a second: give their units"),
    *(_times_as_much(KNOT, *names, remedy="knots were read as metres a second: give the unit")
      for names in (("u",), ("speed_over_ground",), ("u_ground", "v_ground"))),
    *(_times_as_much(factor, "revolutions", remedy=f"they look like turns a {unit}: give their unit")
      for factor, unit in ((1 / 60, "minute"), (60.0, "second"))),
    _turned(-1j, "they are along x and y, not along the ship: call them x_rate and y_rate"),
    _turned(1j, "they are along the ship already: call them u_ground and v_ground"),
)  # fmt: skip
