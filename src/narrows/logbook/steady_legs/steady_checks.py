"""Whether steady legs agree with a model and each other, and what they cannot tell: findings with their evidence."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from narrows.logbook.steady_legs.steady_readings import SteadyReadings
from narrows.logbook.steady_legs.steady_update import SteadyUpdate
from narrows.model.data_range import extrapolation
from narrows.model.model import Model

# Probability of as large a sum of squares, under which legs contradict the model or each other.
CONTRADICTION = 0.01
# Of a sum of squares: the right sign loses so much to the wrong one in fewer than one case of a hundred.
UNLIKELY = 2 * np.log(100)
# Readings that are often written with the other sign.
TURNED = ("rudder", "drift", "heading")
ONE_SIDE = (
    "All legs are on one side of the middle: wind and the zeros of rudder and drift do not cancel, and what was "
    "learned rests on how large they were taken to be; hold the other side too."
)
SCALE = "A steady balance tells ratios of forces: their common size is that of the tests."


@dataclass(frozen=True)
class SteadyChecks:
    """How legs and model agree."""

    chi_square: float  # Sum of squares of what was read over what was to be expected of it [1]
    freedom: int  # What it would be on average
    probability: float  # Of one as large, were model, prior and errors right [1]
    leg_probabilities: dict[str, float]  # The same of each leg, beside all others [1]
    findings: tuple[str, ...]  # What is wrong or cannot be told, a sentence each

    @property
    def contradicted(self) -> bool:
        """Whether the legs contradict the model or each other."""
        return self.probability < CONTRADICTION


def steady_checks(
    model: Model, readings: SteadyReadings, update: SteadyUpdate, again: Callable[[SteadyReadings], SteadyUpdate]
) -> SteadyChecks:  # fmt: skip
    """Check legs against a model and against each other."""
    posterior = update.posterior
    each = _probability(posterior.beside, update.counted // len(readings))
    legs = dict(zip(readings.legs, each.tolist(), strict=True))
    chance = float(_probability(np.array(posterior.chi_square), update.counted))
    findings = [] if readings.both_sides else [ONE_SIDE]
    if chance < CONTRADICTION:
        findings.append(_contradiction(posterior.chi_square, update.counted, legs))
    findings += _other_sign(readings, posterior.chi_square, again)
    if not update.settled:
        findings.append("The search for where the ship truly was did not come to rest; give smaller errors of y and u.")
    asked = {"speed": readings.values["u"], "abs_y": np.abs(readings.values["y"])}
    known = {name: column for name, column in asked.items() if getattr(model.data_range, name)}
    findings += extrapolation(model.data_range, known)
    return SteadyChecks(posterior.chi_square, update.counted, chance, legs, (*findings, SCALE))


def _probability(squares: np.ndarray, freedom: int) -> np.ndarray:
    from scipy.special import chdtrc

    return np.asarray(chdtrc(freedom, np.maximum(squares, 0.0)))


def _contradiction(squares: float, freedom: int, legs: dict[str, float]) -> str:
    worst = min(legs, key=lambda leg: legs[leg])
    return (
        f"The legs contradict the model, each other or their errors: a sum of squares of {squares:.1f} where {freedom} "
        f"was to be expected; leg {worst} fits worst. Hold it again, or look for a fault of an instrument."
    )


def _other_sign(readings: SteadyReadings, squares: float, again: Callable[[SteadyReadings], SteadyUpdate]) -> list[str]:
    """Say which reading fits a hundred times better with the other sign."""
    if squares <= UNLIKELY:  # There is nothing to be won.
        return []
    turned = {name: again(_turned(readings, name)).posterior.chi_square for name in TURNED if name in readings.values}
    return [
        f"With the other sign of {name} the legs fit far better, {other:.1f} instead of {squares:.1f}: is it positive "
        "where it turns the bow to starboard, or where the bow is to starboard?"
        for name, other in turned.items()
        if squares - other > UNLIKELY
    ]


def _turned(readings: SteadyReadings, name: str) -> SteadyReadings:
    return replace(readings, values={**readings.values, name: -readings.values[name]})
