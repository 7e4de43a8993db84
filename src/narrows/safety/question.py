"""What is asked of a safe envelope: which ship, offsets and speeds, against what, and how much is to be left."""

import math
from dataclasses import dataclass

import numpy as np

from narrows.errors import InputError, check_choice
from narrows.model.model import Model
from narrows.model.squat import choke_speed, squat
from narrows.safety.channel_rules import BANKS
from narrows.safety.disturbance import Disturbance

# Where a keel meets the banks [m]: to port and to starboard of the middle.
Walls = tuple[float, float]

# Of the draft, to be left under the keel.
KEEL_SHARE = 0.05

OFFSETS, SPEEDS = 25, 15

# Of the speed that chokes the canal: the range where none is given.
SLOWEST, FASTEST = 0.3, 1.05


@dataclass(frozen=True)
class EnvelopeQuestion:
    """What a safe envelope is asked, complete and checked."""

    model: Model  # Of the ship in its canal
    offsets: np.ndarray  # (offsets,) To starboard of the middle [m]
    speeds: np.ndarray  # (speeds,) Through the water [m/s]
    disturbance: Disturbance  # What throws the ship off
    reserve: float  # Of the rudder, to be left on the steady course [1]
    clearance: float  # To be left under the keel [m]
    most_revolutions: float | None  # Of the engine [1/s]
    walls: Walls  # Where the keel meets the banks, to port and to starboard of the middle [m]
    bank: str = "steep"  # Kind of bank, for the rules from outside
    pilot: str = "regulator"  # Who is tried

    @property
    def rudder_limit(self) -> float:
        """The most rudder [rad] of a steady course that leaves the reserve."""
        return (1 - self.reserve) * self.model.configuration.gear.limit


def envelope_question(
    model: Model, y: np.ndarray | None, u: np.ndarray | None, disturbance: Disturbance | None, reserve: float,
    keel: float | None, most_revolutions: float | None, walls: Walls | None, bank: str = "steep",
    pilot: str = "regulator",
) -> EnvelopeQuestion:  # fmt: skip
    """Return what is asked, with what suits the ship and its canal where nothing is given."""
    # y (offsets,) [m]; u (speeds,) [m/s]; keel [m]; most_revolutions [1/s]; walls [m]
    check_choice("bank", bank, BANKS)
    ship, canal = model.configuration.ship, model.configuration.canal
    least = KEEL_SHARE * ship.draft if keel is None else keel
    if not 0 <= reserve < 1 or not 0 <= least < math.inf:
        raise InputError(
            f"a reserve of {reserve} of the rudder and {least} m under the keel: give a share from 0 to less than 1, "
            "and metres from 0"
        )
    room = walls or (canal.width / 2, canal.width / 2)
    offsets = _offsets(model, room) if y is None else np.atleast_1d(np.asarray(y, float))
    speeds = _speeds(model) if u is None else np.atleast_1d(np.asarray(u, float))
    _check(offsets, speeds, room, ship.beam)
    return EnvelopeQuestion(
        model, offsets, speeds, disturbance or Disturbance(), reserve, least, most_revolutions, room, bank, pilot
    )


def _offsets(model: Model, room: Walls) -> np.ndarray:
    port, starboard = (wall - model.configuration.ship.beam for wall in room)
    if port + starboard <= 0:
        raise InputError("the canal is less than two beams wide: there is no offset to look at; check its width")
    covered = model.data_range.abs_y
    ends = [] if covered is None else [end for end in (-covered[1], covered[1]) if -port < end < starboard]
    return np.union1d(np.linspace(-port, starboard, OFFSETS), ends)


def _speeds(model: Model) -> np.ndarray:
    choke = keel_at(model, np.empty(0)).choke
    if math.isinf(choke):
        raise InputError("without a depth nothing bounds the speed: give the canal's depth, or the speeds to look at")
    asked = np.linspace(SLOWEST, FASTEST, SPEEDS) * choke
    covered = model.data_range.speed or ()
    return np.union1d(asked, [end for end in covered if asked[0] < end < asked[-1]])


def _check(offsets: np.ndarray, speeds: np.ndarray, room: Walls, beam: float) -> None:
    for name, column in (("offsets", offsets), ("speeds", speeds)):
        if not column.size or not np.isfinite(column).all() or (np.diff(column) <= 0).any():
            raise InputError(f"the {name} must be finite and rise; give them in order, none twice")
    if speeds[0] <= 0:
        raise InputError(f"a speed of {speeds[0]:g} m/s steers nothing; give speeds over 0")
    low, high = beam / 2 - room[0], room[1] - beam / 2
    if not (low < offsets[0] and offsets[-1] < high):
        raise InputError(
            f"offsets from {offsets[0]:g} to {offsets[-1]:g} m have the hull in a bank; stay between {low:.4g} and "
            f"{high:.4g} m"
        )


# Water under the keel at speed: the sinkage that the forces ask for, and the largest, which takes the bottom first.
@dataclass(frozen=True)
class Keel:
    """Sinkage and clearance at some speeds."""

    # (speeds,) Sinkage midship; zero where the depth is not known, or where the canal is choked [m]
    midship: np.ndarray
    # (speeds,) Least water under the hull; NaN where the depth is not known, or where the canal is choked [m]
    clearance: np.ndarray
    choke: float  # The speed at which the canal is choked; infinite where the depth is not known [m/s]
    notes: tuple[str, ...]  # What the formulas are used beyond


def keel_at(model: Model, speeds: np.ndarray) -> Keel:
    """Estimate sinkage and clearance at some speeds."""
    # speeds (speeds,) [m/s]
    configuration = model.configuration
    if configuration.canal.depth is None:
        unknown = np.full(len(speeds), np.nan)
        return Keel(np.zeros(len(speeds)), unknown, np.inf, ("the depth is not given: no squat, no choking",))
    choke, room = choke_speed(configuration), configuration.canal.depth - configuration.ship.draft
    midship, clearance, notes = np.zeros(len(speeds)), np.full(len(speeds), np.nan), []
    for index, speed in enumerate(speeds.tolist()):
        if speed < choke:
            ends = [squat(configuration, speed, gives) for gives in ("bow", "largest")]
            middle = squat(configuration, speed)
            midship[index], clearance[index] = middle.sinkage, room - max(end.sinkage for end in ends)
            notes += [f"squat by {estimate.formula}: {word}" for estimate in (middle, *ends) for word in estimate.notes]
    return Keel(midship, clearance, choke, tuple(dict.fromkeys(_without_numbers(note) for note in notes)))


def _without_numbers(note: str) -> str:
    """A warning of one speed as one of all: 'blockage 0.24 is outside 0 to 0.03' without its own value."""
    words = note.split()
    if "outside" not in words:
        return note
    index = words.index("is")
    return " ".join(words[: index - 1] + words[index:])
