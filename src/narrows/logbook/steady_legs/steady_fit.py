"""The answer of steady legs: what they taught of the coefficients, what still comes from the tests, what disagrees."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from narrows.logbook.learned_answer import LearnedAnswer
from narrows.logbook.learned_coefficient import LEARNED, PRIOR, LearnedCoefficient, pairs
from narrows.logbook.standing import ON_TWINS
from narrows.logbook.steady_legs.steady_checks import SteadyChecks
from narrows.logbook.steady_legs.steady_conditions import UNKNOWN, SteadyConditions
from narrows.logbook.steady_legs.steady_readings import SteadyReadings
from narrows.model.model import Model

# What legs share: words, unit to print it in, how many of it one in SI is.
SHARED = {
    "wind_Y": ("sway force of the wind", "N", 1.0), "wind_N": ("yaw moment of the wind", "N m", 1.0),
    "rudder_zero": ("zero of the rudder", "deg", 180 / np.pi), "drift_zero": ("zero of the drift", "deg", 180 / np.pi),
    "heading_zero": ("zero of the heading", "deg", 180 / np.pi), "y_zero": ("zero of the offset", "m", 1.0),
}  # fmt: skip

# What a balance with so much unknown cannot tell.
WHOSE = (
    "Legs that agree do not show that they are of this ship: on twins those of one a quarter shorter or longer agree, "
    "and a rudder of the wrong sign may; see to ship, draft and signs."
)


@dataclass(frozen=True, repr=False)
class SteadyFit(LearnedAnswer):
    """What steady legs taught.

    Parameters
    ----------
    model : Model
        The model that comes out.
    prior : Model
        The model before.
    readings : SteadyReadings
        The legs.
    conditions : SteadyConditions
        What was taken of wind, zeros and what is left of motion.
    coefficients : mapping of str to LearnedCoefficient
        Each before and after.
    shared : mapping of str to (float, float)
        What all legs share, in SI: ``wind_Y``, ``wind_N``, and the zeros ``rudder_zero``, ``drift_zero``,
        ``heading_zero``, ``y_zero``; most likely value and standard error.
    latent : array (legs, 4)
        Where the ship most likely was: y [m], u [m/s], rudder, psi [rad].
    checks : SteadyChecks
        Whether legs and model agree.
    """

    model: Model
    prior: Model
    readings: SteadyReadings
    conditions: SteadyConditions
    coefficients: Mapping[str, LearnedCoefficient]
    shared: Mapping[str, tuple[float, float]]
    latent: np.ndarray
    checks: SteadyChecks

    def __repr__(self) -> str:
        return f"<SteadyFit of {self.readings.summary()}>"

    @property
    def tells(self) -> bool:
        """Whether a coefficient of the bank was learned, and nothing contradicts it."""
        learned = any(c.word == LEARNED for c in self.coefficients.values() if c.from_bank)
        return learned and not self.checks.contradicted

    @property
    def notes(self) -> tuple[str, ...]:
        """What disagrees or cannot be told, what is known only as a pair, what was taken for granted."""
        together = pairs(self.coefficients, np.asarray(self.model.covariance))
        told = [f"{name} goes with {other} (correlation {by:+.2f}): together they are known better than either."
                for name, other, by in together]  # fmt: skip
        taken = f"Taken for granted: {self.conditions.summary()}."
        whose = () if self.checks.contradicted else (WHOSE,)
        return (*self.checks.findings, *told, taken, *whose, ON_TWINS)

    def summary(self) -> str:
        """Say what was learned, what still comes from the tests, and whether the legs agree."""
        by_word = {word: [c for c in self.coefficients.values() if c.word == word] for word in (LEARNED, PRIOR)}
        bank = [c for c in self.coefficients.values() if c.from_bank and c.word != PRIOR]
        first = "; ".join(c.sentence() for c in bank) or "nothing of the bank"
        others = [c.name for c in by_word[LEARNED] if not c.from_bank]
        also = f" Learned with them: {', '.join(others)}." if others else ""
        open_still = [c.name for c in by_word[PRIOR] if c.prior_std > 0]
        rest = f"From the tests still: {', '.join(open_still)}." if open_still else ""
        agree = (
            f"The legs {'contradict' if self.checks.contradicted else 'agree with'} the model: a sum of squares of "
            f"{self.checks.chi_square:.1f}, {self.checks.freedom} expected."
        )
        lines = f"Learned from {self.readings.summary()}: {first}.{also}", rest, agree, ON_TWINS
        return "\n".join(filter(None, lines))

    def to_dict(self) -> dict[str, Any]:
        """Give everything by name: part of what ``learn --steady --json`` prints."""
        return {
            "summary": self.summary(),
            "tells": self.tells,
            "coefficients": [coefficient.to_dict() for coefficient in self.coefficients.values()],
            "shared": [
                {"name": name, "unit": SHARED[name][1], "value": value * SHARED[name][2], "std": std * SHARED[name][2],
                 "prior_std": before * SHARED[name][2]}
                for (name, (value, std)), before in zip(
                    self.shared.items(), self.conditions.shared(self.prior).tolist(), strict=True)
            ],
            "chi_square": self.checks.chi_square,
            "freedom": self.checks.freedom,
            "probability": self.checks.probability,
            "contradicted": self.checks.contradicted,
            "legs": self.leg_rows(),
            "source": {"table": self.readings.source, "sha256": self.readings.sha256},
            "notes": list(self.notes),
        }  # fmt: skip

    def leg_rows(self) -> list[dict[str, Any]]:
        """Give a row a leg: what was read, where the ship most likely was, and how well the leg fits the others."""
        read = self.readings.values
        direction = read[self.readings.directions[0]]
        return [
            {
                "leg": leg, "y": float(read["y"][i]), "u": float(read["u"][i]),
                "rudder_deg": float(np.degrees(read["rudder"][i])), "direction_deg": float(np.degrees(direction[i])),
                "likely_y": float(self.latent[i, 0]), "likely_rudder_deg": float(np.degrees(self.latent[i, 2])),
                "likely_heading_deg": float(np.degrees(self.latent[i, 3])),
                "probability": self.checks.leg_probabilities[leg],
            }
            for i, leg in enumerate(self.readings.legs)
        ]  # fmt: skip


def shared_of(mean: np.ndarray, covariance: np.ndarray) -> dict[str, tuple[float, float]]:
    """Return what all legs share, with its standard errors."""
    # mean (n,); covariance (n, n)
    std = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    last = zip(mean[-len(UNKNOWN) :].tolist(), std[-len(UNKNOWN) :].tolist(), strict=True)
    return dict(zip(UNKNOWN, last, strict=True))
