"""Water under the keel at speed: the sinkage that the forces ask for, and the largest, which takes the bottom first."""

from dataclasses import dataclass

import numpy as np

from narrows.model.model import Model
from narrows.model.squat import choke_speed, squat


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
