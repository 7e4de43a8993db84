"""What the page draws: the ship, the banks about it, and where it may go, in metres east and north."""

from contextlib import suppress
from typing import Any

import numpy as np

from narrows.errors import InputError
from narrows.warning.forecasting.predicted_fan import PredictedFan
from narrows.warning.monitoring.bridge_monitor import BridgeMonitor
from narrows.warning.monitoring.bridge_status import BridgeStatus
from narrows.waterway.waterway import Waterway

ASTERN, AHEAD, EVERY = 800.0, 2400.0, 20.0
"""Of the ship, how much of the banks is drawn; and how far apart their points are [m]."""


def scene(watched: BridgeMonitor, status: BridgeStatus) -> dict[str, Any] | None:
    """Return what there is to draw, points as [north, east] [m]; None where nobody knows where the ship is (ours).

    Parameters
    ----------
    watched : BridgeMonitor
        Of which ship.
    status : BridgeStatus
        As it is.
    """
    if not status.estimate.ready:
        return None
    way, ship, now = watched.waterway, watched.model.configuration.ship, status.estimate.values
    pose = np.array([now["x"], now["y"], now["psi"]])
    along = min(max(now["x"], 0.0), way.line.length)
    return {
        "ship": {"pose": _on_map(way, pose), "length": ship.length, "beam": ship.beam},
        "middle": _on_map(way, np.array([along, float(way.room(along, ship.draft).middle), 0.0])),
        "banks": _banks(way, along, None),
        "limits": _banks(way, along, ship.draft),
        "fan": _fan(way, pose, _foretold(watched, status)),
    }


def _foretold(watched: BridgeMonitor, status: BridgeStatus) -> PredictedFan | None:
    with suppress(InputError):  # A picture is no reason to stop watching.
        return watched.fan(status) if status.forecast else None
    return None


def _banks(way: Waterway, along: float, draft: float | None) -> list[Any]:
    """Of the water, or of the room for a keel: to port and to starboard."""
    first, last = max(along - ASTERN, 0.0), min(along + AHEAD, way.line.length)
    s = np.linspace(first, last, max(2, round((last - first) / EVERY) + 1))
    here = way.section(s) if draft is None else way.room(s, draft)
    return [_points(way.to_map(s, here.middle + side * here.width / 2)[0]) for side in (-1, 1)]


def _fan(way: Waterway, pose: np.ndarray, fan: PredictedFan | None) -> dict[str, Any] | None:
    if fan is None:
        return None
    tracks = {"likely": fan.likely, "pilot": fan.pilot}
    members = [np.concatenate([pose[None], member]) for member in fan.members]
    return {
        "times": fan.times.tolist(),
        "members": [_points(way.to_map(member[:, 0], member[:, 1])[0]) for member in members],
        **{name: [_on_map(way, each) for each in track] for name, track in tracks.items()},
    }


def _on_map(way: Waterway, pose: np.ndarray) -> list[float]:
    """North and east [m], and the heading [rad]."""
    place, heading = way.to_map(*pose)
    return [*_points(place[None])[0], round(float(heading), 4)]


def _points(places: np.ndarray) -> list[list[float]]:
    """North before east, to a decimetre."""
    return np.round(places[:, ::-1], 1).tolist()  # type: ignore[no-any-return]
