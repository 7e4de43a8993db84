"""Which tuning of a pilot is tried: the one that holds most of other samples than those it is judged by."""

import numpy as np

from narrows.errors import check_choice
from narrows.safety.bounds import Bounds
from narrows.safety.held_trials import ChosenPilot, trials
from narrows.safety.pilots import PILOTS
from narrows.safety.question import EnvelopeQuestion

# Of the trials that choose, and at how many places.
SAMPLES, OFFSETS, SPEEDS = 200, 5, 2
# Sets the samples that choose apart from those that judge.
ASIDE = 13


def check_pilot(name: str) -> None:
    """Raise where there is no pilot of a name."""
    check_choice("controller", name, PILOTS)


def choose_pilot(question: EnvelopeQuestion, bounds: Bounds, seed: int, workers: int | None) -> ChosenPilot:
    """Choose the tuning of a pilot that holds most samples at a few of the offsets and speeds asked about."""
    pilot = PILOTS[question.pilot]
    if len(pilot.tunings) == 1:
        return ChosenPilot(pilot, pilot.tunings[0])
    open_to = np.flatnonzero(bounds.clear) if bounds.clear.any() else np.arange(len(question.speeds))
    speeds, offsets = open_to[_spread(len(open_to), SPEEDS)], _spread(len(question.offsets), OFFSETS)
    other_seed = int(np.random.SeedSequence((abs(seed), ASIDE)).generate_state(1)[0])
    shares = []
    for tuning in pilot.tunings:
        tried = trials(
            question.model, question.offsets[offsets], question.speeds[speeds], bounds.under.midship[speeds],
            question.disturbance, SAMPLES, other_seed, question.walls, ChosenPilot(pilot, tuning), knowing=False,
            workers=workers,
        )  # fmt: skip
        safe = (np.abs(tried["rudder"]) <= question.rudder_limit) & tried["held"]
        shares.append(float(safe.mean()))
    return ChosenPilot(pilot, pilot.tunings[int(np.argmax(shares))])


def _spread(size: int, most: int) -> np.ndarray:
    """At most so many places of a row, evenly, none at its ends where there are more."""
    if size <= most:
        return np.arange(size)
    return np.unique(np.round((np.arange(most) + 0.5) * size / most - 0.5).astype(int))
