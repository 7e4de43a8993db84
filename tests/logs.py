"""Logs for tests: a ship in a bend as its sensors would record it, and sentences of NMEA 0183."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, reduce
from operator import xor
from pathlib import Path

import numpy as np
import pandas as pd

import narrows as nw
from narrows.logbook.transits import TransitTwin
from narrows.waterway import Bank, Centreline

Told = Mapping[str, np.ndarray]


def bent_waterway(radius: float = 3000.0, length: float = 4000.0) -> nw.Waterway:
    """A bend to starboard of constant radius, 300 m wide, at 5 E, 52 N."""
    turned = np.linspace(0.0, length / radius, 60)
    points = radius * np.stack([1 - np.cos(turned), np.sin(turned)], axis=1)
    ends, half = np.array([0.0, length]), np.full(2, 150.0)
    return nw.Waterway(
        Centreline(points), Bank("starboard", ends, half), Bank("port", ends, half), (ends, np.full(2, 30.0)),
        name="bend", origin=(5.0, 52.0),
    )  # fmt: skip


def motion(t: np.ndarray) -> dict[str, np.ndarray]:
    """A smooth way along a waterway: place, heading to it, and where the rudder was."""
    return {
        "x": 300.0 + 4.0 * t, "y": 12.0 * np.sin(t / 60.0), "psi": 0.05 * np.sin(t / 45.0 + 0.3),
        "rudder": 0.1 * np.sin(t / 30.0),
    }  # fmt: skip


def antenna_on_earth(waterway: nw.Waterway, told: Told, antenna: tuple[float, float]) -> pd.DataFrame:
    """Longitude and latitude of an antenna, and the heading from north [deg], of a ship along a waterway."""
    from narrows.waterway.map_lines import unprojected

    positions, heading = waterway.to_map(told["x"], told["y"], told["psi"])
    ahead = np.stack([np.sin(heading), np.cos(heading)], axis=1)
    starboard = np.stack([ahead[:, 1], -ahead[:, 0]], axis=1)
    degrees = unprojected(positions + antenna[0] * ahead + antenna[1] * starboard, np.array(waterway.origin))
    return pd.DataFrame({"lon": degrees[:, 0], "lat": degrees[:, 1], "HDG [deg]": np.degrees(heading) % 360})


def sentence(body: str) -> str:
    """A sentence with its checksum."""
    return f"${body}*{reduce(xor, body.encode(), 0):02X}"


def angle(degrees: float, sides: str) -> str:
    """A latitude or longitude as sentences write it, to a hundredth of a millimetre."""
    whole, minutes = divmod(abs(degrees) * 60, 60)
    width = 2 if sides == "NS" else 3
    return f"{int(whole):0{width}d}{minutes:011.8f},{sides[int(degrees < 0)]}"


def clock(seconds: float) -> str:
    """Of the day, as sentences write it."""
    return f"{int(seconds // 3600):02d}{int(seconds % 3600 // 60):02d}{seconds % 60:05.2f}"


def write_recording(path: Path, lines: list[str]) -> Path:
    path.write_bytes("".join(f"{line}\r\n" for line in lines).encode("ascii"))
    return path


D = np.pi / 180
NOISE = {
    "x": 0.7, "y": 0.7, "psi": 0.15 * D, "r": 0.1 * D, "u": 0.1, "u_ground": 0.1, "v_ground": 0.1, "rudder": 0.4 * D,
    "speed_over_ground": 0.1, "course": 0.5 * D, "wind_speed": 0.5, "wind_direction": 5 * D,
}  # fmt: skip
"""Standard deviations of what a voyage data recorder hears, about."""
WIND, WIND_FROM = 9.0, 0.7


def sensed(name: str, voyage: nw.Voyage, seed: int = 0, noise: float = 1.0) -> nw.ShipRecord:
    """A voyage as a ship's sensors record it, each second, with a steady wind and noise."""
    rng = np.random.default_rng(seed)
    track = voyage.psi + np.arctan2(voyage.v, voyage.u)
    told = {
        **{own: voyage[own] for own in ("x", "y", "psi", "r", "u", "rudder")}, "u_ground": voyage.u,
        "v_ground": voyage.v, "speed_over_ground": np.hypot(voyage.u, voyage.v), "course": track,
        "wind_speed": np.full(len(voyage), WIND), "wind_direction": np.full(len(voyage), WIND_FROM),
    }  # fmt: skip
    noisy = {own: column + noise * NOISE[own] * rng.standard_normal(len(column)) for own, column in told.items()}
    noisy["revolutions"] = np.full(len(voyage), 1.5)
    return nw.ShipRecord(name, {own: nw.Signal(voyage.t, column) for own, column in noisy.items()})


@cache
def kvlcc2() -> nw.Model:
    """KVLCC2 at full size."""
    return nw.scale_model(nw.published("yasukawa2015_kvlcc2"), 320.0).model


@cache
def trial(law: nw.ControlLaw, duration: float) -> nw.Voyage:
    """In open water."""
    told = {"u": 7.0, "duration": duration, "dt": 1.0, "contact": "none", "surge": "free"}
    return nw.simulate(kvlcc2(), controller=law, **told)


@cache
def zigzag(rudder_deg: float = 20.0, seed: int = 0) -> nw.ShipRecord:
    """A zigzag in open water."""
    law = nw.Zigzag(rudder_deg * D, abs(rudder_deg) * D)
    return sensed(f"zigzag {rudder_deg:+g}", trial(law, 900.0), seed)


@cache
def circle(rudder_deg: float = 35.0, seed: int = 0) -> nw.ShipRecord:
    """A turning circle."""
    return sensed("circle", trial(nw.ConstantRudder(rudder_deg * D), 1500.0), seed)


@cache
def round_the_bend() -> nw.Voyage:
    """Along a bend, in which the ship is afloat all the way."""
    pilot = nw.Autopilot(0.0, (0.003, 1.5, 0.0, 25.0))
    way = {"waterway": bent_waterway(length=9000.0), "controller": pilot}
    return nw.simulate(kvlcc2(), x=500.0, y=10.0, u=5.0, duration=1200.0, dt=1.0, **way)


@cache
def bend(seed: int = 0) -> nw.ShipRecord:
    """A way round a bend, along it."""
    return sensed("bend", round_the_bend(), seed)


@dataclass(frozen=True)
class PassedTransit(TransitTwin):
    """A transit on which other ships pass at some times [s]: off, on, off again in sway, out and back in yaw."""

    # No measured passing force is behind it: its size is that of a bank's suction and its time that of two lengths at
    # twice the speed.
    passes: tuple[float, ...] = ()

    def _pushes(self, draw: np.random.Generator) -> dict[str, list[tuple[float, float]]]:
        ship, pushes = self.truth.configuration.ship, super()._pushes(draw)
        size = 0.02 * self.truth.configuration.water.density * self.u**2 * ship.length * ship.draft
        times = np.array(pushes["Y"])[:, 0]
        phases = [np.clip((times - passed) * self.u / ship.length, -1.0, 1.0) for passed in self.passes]
        sway = sum((-size * np.cos(1.5 * np.pi * phase) * (np.abs(phase) < 1) for phase in phases), 0.0 * times)
        yaw = sum((0.15 * ship.length * size * np.sin(np.pi * phase) for phase in phases), 0.0 * times)
        return {
            name: [(t, value + more) for (t, value), more in zip(pushes[name], added.tolist(), strict=True)]
            for name, added in (("Y", sway), ("N", yaw))
        }
