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


def heading(change: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> Spoil:
    return lambda record: record.with_signals(
        psi=nw.Signal(record["psi"].t, change(record["psi"].t, record["psi"].values))
    )


def blown(change: Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]) -> Spoil:
    """A wind, as a complex number towards where it comes from, changed by the ship's velocity and heading."""

    def spoil(record: nw.ShipRecord) -> nw.ShipRecord:
        psi = record["psi"].values
        ship = (record["u_ground"].values + 1j * record["v_ground"].values) * np.exp(1j * psi)
        wind = record["wind_speed"].values * np.exp(1j * record["wind_direction"].values)
        told, t = change(wind, ship, psi), record["psi"].t
        direction = np.unwrap(np.angle(told))
        return record.with_signals(wind_speed=nw.Signal(t, np.abs(told)), wind_direction=nw.Signal(t, direction))

    return spoil


def rolling(record: nw.ShipRecord) -> nw.ShipRecord:
    t = record["r"].t
    return record.with_signals(r=nw.Signal(t, 0.01 * np.sin(2 * np.pi * t / 13.0)))


def cut(record: nw.ShipRecord) -> nw.ShipRecord:
    kept = {name: (own.t < 300.0) | (own.t > 380.0) for name, own in record.signals.items()}
    return record.with_signals(
        **{name: nw.Signal(own.t[kept[name]], own.values[kept[name]]) for name, own in record.signals.items()}
    )


FAULTS: dict[str, tuple[Spoil, str, str]] = {
    "a rudder positive to port": (scaled(-1.0, "rudder"), "rudder's sign", '[positive] rudder = "port"'),
    "a rudder in degrees": (scaled(DEGREES, "rudder"), "rudder", "head it 'rudder [deg]'"),
    "a rudder in radians read as degrees": (scaled(1 / DEGREES, "rudder"), "rudder's unit", "radians taken as degrees"),
    "no rudder": (without("rudder"), "missing", "voyage data recorder"),
    "a rudder that never moves": (scaled(0.0, "rudder"), "rudder", "another column"),
    "a heading to port": (scaled(-1.0, "psi"), "heading", "psi counts to port"),
    "a heading in degrees": (scaled(DEGREES, "psi"), "heading", "psi counts degrees"),
    "heading and yaw rate in degrees": (scaled(DEGREES, "psi", "r"), "yaw rate", "degrees a second"),
    "a heading that wraps": (heading(lambda t, psi: (psi + 3.0 + np.pi) % (2 * np.pi) - np.pi), "heading", "unwrap"),
    "a compass that was reset": (heading(lambda t, psi: psi + 0.35 * (t > 450.0)), "heading", "compass"),
    "a compass that is stuck": (held("psi"), "stuck", "leave that time out"),
    "a yaw rate to port": (scaled(-1.0, "r"), "yaw rate", '[positive] r = "port"'),
    "a yaw rate in degrees a second": (scaled(DEGREES, "r"), "yaw rate", "degrees a second"),
    "a yaw rate in degrees a minute": (scaled(60 * DEGREES, "r"), "yaw rate", "or a minute"),
    "a yaw rate half as large": (scaled(0.5, "r"), "yaw rate", "calibration"),
    "a roll rate for the yaw rate": (rolling, "yaw rate", "roll rate"),
    "a gyro that is stuck": (held("r"), "stuck", "leave that time out"),
    "a position that is stuck": (held("x", "y"), "stuck", "leave that time out"),
    "y to port": (scaled(-1.0, "y"), "heading", "y counts to port"),
    "velocities in fixed axes": (turned(1j), "velocity over ground", "x_rate and y_rate"),
    "velocities turned once too often": (turned(-1j), "velocity over ground", "along the ship already"),
    "a sway velocity to port": (scaled(-1.0, "v_ground"), "velocity over ground", "v_ground counts to port"),
    "velocities in knots": (scaled(KNOTS, "u_ground", "v_ground"), "velocity over ground", "knots"),
    "a speed over ground in knots": (scaled(KNOTS, "speed_over_ground"), "speed over ground", "knots"),
    "a course to port": (scaled(-1.0, "course"), "speed over ground", "course counts to port"),
    "a course in degrees": (scaled(DEGREES, "course"), "speed over ground", "course counts degrees"),
    "a log in knots": (scaled(KNOTS, "u"), "speed through the water", "knots"),
    "revolutions a minute": (scaled(60.0, "revolutions"), "revolutions", "revolutions [rpm]"),
    "a clock that was set back": (clocked(-20.0), "clock", "sort"),
    "a clock that was set on": (clocked(60.0), "clock", "jump"),
    "an antenna on the deckhouse": (moved(-130.0), "antenna", "antenna's place"),
    "the wind as felt on board": (blown(lambda wind, ship, psi: wind + ship), "wind", "felt on board"),
    "a wind told by where it goes": (blown(lambda wind, ship, psi: -wind - 2 * ship), "wind", "where the wind goes"),
    "a wind told from the bow": (blown(lambda wind, ship, psi: wind * np.exp(-1j * psi)), "wind", "from the bow"),
}  # fmt: skip


def ashore(record: nw.ShipRecord) -> nw.ShipRecord:
    """A hull that lies 90 m further to port than it did, in a bank of the waterway that it goes round."""
    return record.with_signals(y=nw.Signal(record["y"].t, record["y"].values - 90.0))
