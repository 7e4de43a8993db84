"""Faults of a ship's log, one at a time: what each does to a good record, by what check it is found, and its remedy."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

import narrows as nw

DEGREES, KNOTS = 180 / np.pi, 3600 / 1852
Spoil = Callable[[nw.ShipRecord], nw.ShipRecord]


def scaled(factor: float, *names: str) -> Spoil:
    """Signals as another sign or unit has them."""
    return lambda record: record.with_signals(
        **{name: nw.Signal(record[name].t, factor * record[name].values) for name in names}
    )


def without(name: str) -> Spoil:
    return lambda record: replace(record, signals={own: record[own] for own in record if own != name})


def held(*names: str) -> Spoil:
    """Signals that say the same from a third of the record on to two thirds."""

    def spoil(record: nw.ShipRecord) -> nw.ShipRecord:
        told = {}
        for name in names:
            t, values = record[name].t, record[name].values
            first, last = np.searchsorted(t, record.start + record.duration * np.array([1, 2]) / 3)
            stuck = np.where((np.arange(len(t)) >= first) & (np.arange(len(t)) <= last), values[first], values)
            told[name] = nw.Signal(t, stuck)
        return record.with_signals(**told)

    return spoil


def clocked(shift: float) -> Spoil:
    """Times that are set on, or back, halfway."""

    def spoil(record: nw.ShipRecord) -> nw.ShipRecord:
        halfway = record.start + record.duration / 2
        moved = {name: nw.Signal(np.where(own.t > halfway, own.t + shift, own.t), own.values)
                 for name, own in record.signals.items()}  # fmt: skip
        return record.with_signals(**moved)

    return spoil


def turned(way: complex) -> Spoil:
    """Velocities over ground turned by so many times the heading: into fixed axes, or once too often."""

    def spoil(record: nw.ShipRecord) -> nw.ShipRecord:
        told = (record["u_ground"].values + 1j * record["v_ground"].values) * np.exp(way * record["psi"].values)
        t = record["u_ground"].t
        return record.with_signals(u_ground=nw.Signal(t, told.real), v_ground=nw.Signal(t, told.imag))

    return spoil


def moved(forward: float) -> Spoil:
    """Positions of an antenna."""

    def spoil(record: nw.ShipRecord) -> nw.ShipRecord:
        t, psi = record["x"].t, record["psi"].values
        x, y = record["x"].values + forward * np.cos(psi), record["y"].values + forward * np.sin(psi)
        return record.with_signals(x=nw.Signal(t, x), y=nw.Signal(t, y))

    return spoil


def late(delay: float, *names: str) -> Spoil:
    """Signals that are recorded late: before the first has come there is none, for a held one would be a step."""
    return lambda record: record.with_signals(**{
        name: nw.Signal(record[name].t + delay, record[name].values).between(record.start, record.stop)
        for name in names
    })  # fmt: skip


def off(zero: float, name: str, share: float = 0.0) -> Spoil:
    """A signal with a zero, from a share of the record on."""

    def spoil(record: nw.ShipRecord) -> nw.ShipRecord:
        own = record[name]
        after = own.t >= record.start + share * record.duration
        return record.with_signals(**{name: nw.Signal(own.t, own.values + zero * after)})

    return spoil


def repeated(count: int, *names: str) -> Spoil:
    """Values that are written again and again."""
    return lambda record: record.with_signals(**{
        name: nw.Signal(record[name].t, record[name].values[np.arange(len(record[name])) // count * count])
        for name in names
    })  # fmt: skip


def rolling(record: nw.ShipRecord) -> nw.ShipRecord:
    t = record["r"].t
    return record.with_signals(r=nw.Signal(t, 0.01 * np.sin(2 * np.pi * t / 13.0)))


def seldom(record: nw.ShipRecord) -> nw.ShipRecord:
    """A rudder that is recorded each 0.3 ship lengths of a tanker of 320 m."""
    rudder, every = record["rudder"], round(0.3 * 320.0 / 7.0)
    return record.with_signals(rudder=nw.Signal(rudder.t[::every], rudder.values[::every]))


FAULTS: dict[str, tuple[Spoil, str, str]] = {
    "a rudder positive to port": (scaled(-1.0, "rudder"), "rudder", '[positive] rudder = "port"'),
    "a rudder in degrees": (scaled(DEGREES, "rudder"), "rudder", "head it 'rudder [deg]'"),
    "a rudder in radians read as degrees": (scaled(1 / DEGREES, "rudder"), "rudder", "radians were read as degrees"),
    "a rudder half as large": (scaled(0.5, "rudder"), "rudder gain", "calibration"),
    "no rudder": (without("rudder"), "missing", "record what is missing"),
    "a rudder that never moves": (scaled(0.0, "rudder"), "rudder", "another column"),
    "a rudder 8 s late": (late(8.0, "rudder"), "rudder delay", "[late] rudder"),
    "a heading to port": (scaled(-1.0, "psi"), "psi", '[positive] psi = "port"'),
    "a heading in degrees": (scaled(DEGREES, "psi"), "psi", "psi [deg]"),
    "heading and yaw rate in degrees": (scaled(DEGREES, "psi", "r"), "psi and r", "degrees a second"),
    "a heading 12 degrees off": (off(12 / DEGREES, "psi"), "psi zero", "correct its zero"),
    "a compass that was reset": (off(0.35, "psi", 0.5), "psi step", "begin another record"),
    "a compass that is stuck": (held("psi"), "stuck", "leave that time out"),
    "a yaw rate to port": (scaled(-1.0, "r"), "r", '[positive] r = "port"'),
    "a yaw rate in degrees a second": (scaled(DEGREES, "r"), "r", "degrees a second"),
    "a yaw rate in degrees a minute": (scaled(60 * DEGREES, "r"), "r", "degrees a minute"),
    "a yaw rate half as large": (scaled(0.5, "r"), "r gain", "calibration"),
    "a roll rate for the yaw rate": (rolling, "r gain", "calibration"),
    "a gyro that is stuck": (held("r"), "stuck", "leave that time out"),
    "a position that is stuck": (held("x", "y"), "stuck", "leave that time out"),
    "y to port": (scaled(-1.0, "y"), "y", '[positive] y = "port"'),
    "a position that jumps 15 m": (off(15.0, "y", 0.5), "y step", "begin another record"),
    "an antenna on the deckhouse": (moved(-130.0), "antenna", "antenna's place"),
    "values written ten times": (repeated(10, "x", "y"), "repeats", "leave repeated values out"),
    "velocities in fixed axes": (turned(1j), "u_ground and v_ground", "x_rate and y_rate"),
    "velocities turned once too often": (turned(-1j), "u_ground and v_ground", "along the ship already"),
    "a sway velocity to port": (scaled(-1.0, "v_ground"), "v_ground", '[positive] v_ground = "port"'),
    "velocities in knots": (scaled(KNOTS, "u_ground", "v_ground"), "u_ground and v_ground", "knots"),
    "a speed over ground in knots": (scaled(KNOTS, "speed_over_ground"), "speed_over_ground", "knots"),
    "a course to port": (scaled(-1.0, "course"), "course", '[positive] course = "port"'),
    "a course in degrees": (scaled(DEGREES, "course"), "course", "course [deg]"),
    "a log in knots": (scaled(KNOTS, "u"), "u", "knots"),
    "revolutions a minute": (scaled(60.0, "revolutions"), "revolutions", "turns a minute"),
    "a clock that was set back": (clocked(-20.0), "clock", "sort"),
}  # fmt: skip


def ashore(record: nw.ShipRecord) -> nw.ShipRecord:
    """A hull that lies 90 m further to port than it did, in a bank of the waterway that it goes round."""
    return record.with_signals(y=nw.Signal(record["y"].t, record["y"].values - 90.0))
