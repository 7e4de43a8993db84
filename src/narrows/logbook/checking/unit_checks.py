"""Sizes that no ship has: a rudder beyond its gear, revolutions that no propeller makes, a speed beyond the hull's."""

from collections.abc import Iterator

import numpy as np

from narrows.logbook.checking.examined import Examined
from narrows.logbook.checking.finding import Finding
from narrows.quantities.constants import GRAVITY

# Of the gear's limit, which no rudder passes.
BEYOND = 1.3
DEGREE = np.pi / 180
# Advance ratios J = U / (n D) between which a ship under way sails.
ADVANCE = (0.08, 5.0)
# Of a propeller over the draft, where the model does not say.
DIAMETER = 0.65
# Radians that no ship turns on the way of its own length.
SHARPEST = 3.0
# Froude number that no displacement ship reaches.
FASTEST = 0.5


def check_units(at: Examined) -> Iterator[Finding]:
    """Yield what no ship of this size does."""
    yield from _speed(at)
    yield from _rudder(at)
    yield from _revolutions(at)
    yield from _yaw_rate(at)


def _speed(at: Examined) -> Iterator[Finding]:
    froude = at.speed / np.sqrt(GRAVITY * at.length)
    if froude > FASTEST:
        yield at.finding(
            "speed", f"at {at.speed:.3g} m/s a ship of {at.length:.4g} m has a Froude number of {froude:.2f}, which no "
            "displacement ship reaches",
            "give the log the model of its own ship's size (nw.scale_model), and positions and speeds in metres",
            {"speed": at.speed, "froude": froude},
        )  # fmt: skip


def _rudder(at: Examined) -> Iterator[Finding]:
    if "rudder" not in at.record:
        return
    most, limit = float(np.quantile(np.abs(at.record["rudder"].values), 0.99)), at.model.configuration.gear.limit
    if most <= BEYOND * limit:
        return
    degrees = most <= BEYOND * limit / DEGREE
    yield at.finding(
        "rudder",
        f"the rudder reaches {np.degrees(most):.4g} deg, where the gear's limit is {np.degrees(limit):.3g} deg",
        "it looks like degrees taken as radians: head it 'rudder [deg]'" if degrees else "check its unit, and the gear",
        {"rudder_deg": np.degrees(most), "limit_deg": np.degrees(limit)}, wrong=degrees,
    )  # fmt: skip


def _yaw_rate(at: Examined) -> Iterator[Finding]:
    if "r" not in at.record:
        return
    turns = float(np.quantile(np.abs(at.record["r"].values), 0.99)) * at.motion.pace
    if turns > SHARPEST:
        yield at.finding(
            "yaw rate", f"the ship would turn by {np.degrees(turns):.3g} deg on the way of its own length",
            "r looks like degrees a second, or a minute, taken as radians a second: give its unit", {"turns": turns},
        )  # fmt: skip


def _revolutions(at: Examined) -> Iterator[Finding]:
    if "revolutions" not in at.record:
        return
    turns = float(np.median(np.abs(at.record["revolutions"].values)))
    propeller, ship = at.model.configuration.propeller, at.model.configuration.ship
    diameter = propeller.diameter if propeller else DIAMETER * ship.draft
    if not turns > 0:
        return
    advance = at.speed / (turns * diameter)
    if ADVANCE[0] <= advance <= ADVANCE[1]:
        return
    causes = {60.0: "turns a minute taken as turns a second: head them 'revolutions [rpm]'",
              1 / 60: "turns a second taken as turns a minute: head them 'revolutions [1/s]'"}  # fmt: skip
    cause = next((word for factor, word in causes.items() if ADVANCE[0] <= factor * advance <= ADVANCE[1]), None)
    yield at.finding(
        "revolutions",
        f"at {turns:.4g} turns a second and {at.speed:.3g} m/s a propeller of {diameter:.3g} m has an advance ratio of "
        f"{advance:.2g}",
        f"they look like {cause}" if cause else "check the unit of the revolutions",
        {"revolutions": turns, "advance_ratio": advance}, wrong=cause is not None,
    )  # fmt: skip
