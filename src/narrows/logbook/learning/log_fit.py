"""Result of learning from a log: learned coefficients, prior coefficients, errors of forecasts."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from narrows.logbook.learned_coefficient import LEARNED, ON_TWINS, LearnedAnswer, LearnedCoefficient
from narrows.logbook.learning.record_answers import RecordAnswer
from narrows.model.model import Model

IN_OPEN_WATER = "Learning in open water is tested against measured manoeuvres."  # Note for models without bank terms
CONTRADICTION_PROBABILITY = 1e-3  # Probability below which log and prior contradict each other
# Disturbances over prior gusts that gusts do not explain: of twins in gusts alone 5 % exceed 5, and of twins that
# another ship passes every ten minutes 90 % exceed 17.
UNEXPLAINED_GUST_RATIO = 8.0
HEADING_LEFT = np.radians(0.5)  # Residual noise of headings that exceeds the error of a compass [rad]
MOVED_STDS = 3.0  # Prior standard deviations by which a named coefficient moved


# What ``to_dict`` gives of each record.
RECORD_FIELDS = ("name", "duration", "steps", "met", "zeros", "information", "moved", "whole")


class Gusts(NamedTuple):
    """Most likely Gauss-Markov disturbance of the records."""

    sway: float  # Standard deviation of the acceleration [m/s2]
    yaw: float  # Likewise [rad/s2]
    memory: float  # Correlation time [s]
    correlation: float  # Between the two [1]
    strength: float  # Standard deviation over the prior one, the larger of sway and yaw [1]


class SignalNoise(NamedTuple):
    size: float  # Standard deviation of a reading [unit of the signal]
    beyond: float  # Share of readings that count less as outliers [1]


@dataclass(frozen=True, repr=False)
class LogFit(LearnedAnswer):
    """Result of learning from a log.

    Parameters
    ----------
    model : Model
        Learned model.
    prior : Model
        Model and covariance before the log.
    coefficients : mapping of str to LearnedCoefficient
        Coefficients before and after.
    records : tuple of RecordAnswer
        Contribution of each record.
    gusts : Gusts, optional
        None if gusts were not estimated.
    noise : mapping of str to SignalNoise
        Most likely noise of a reading of each signal.
    disagreement : float [1]
        Sum of squared changes of the coefficients over their expected errors.
    freedom : int
        Number of combinations of coefficients that the log determines.
    probability : float [1]
        Probability of at least this disagreement if log and prior belong to one ship.
    held : tuple of str
        Inertia coefficients that keep their prior: motion determines only ratios of forces to inertia.
    about : tuple of str
        Assumptions, and records that were left out.
    settled : bool
        Whether the search converged.
    """

    model: Model
    prior: Model
    coefficients: Mapping[str, LearnedCoefficient]
    records: tuple[RecordAnswer, ...]
    gusts: Gusts | None
    noise: Mapping[str, SignalNoise]
    disagreement: float
    freedom: int
    probability: float
    held: tuple[str, ...]
    about: tuple[str, ...]
    settled: bool

    @property
    def _size(self) -> str:
        hours = sum(record.duration for record in self.records) / 3600
        lasting = f"{hours:.3g} h" if hours >= 1 else f"{60 * hours:.3g} min"
        return f"{len(self.records)} {'record' if len(self.records) == 1 else 'records'}, {lasting}"

    @property
    def informative(self) -> bool:
        """True where the log determined a coefficient: one of the bank, where the model has one."""
        asked = [c for c in self.coefficients.values() if c.from_bank or not self.prior.has_bank]
        return any(c.word == LEARNED for c in asked)

    @property
    def disagrees(self) -> bool:
        """True where log and prior contradict each other."""
        return self.probability < CONTRADICTION_PROBABILITY

    @property
    def pushed(self) -> bool:
        """True where disturbances are too strong for gusts, as with passing ships that the log lacks."""
        return self.gusts is not None and self.gusts.strength > UNEXPLAINED_GUST_RATIO

    @property
    def notes(self) -> tuple[str, ...]:
        """Contradictions, inseparable pairs, assumptions, left-out records, and coefficients that fix the rest."""
        inertia = f"Motion determines only forces over inertia. Inertia keeps its prior: {', '.join(self.held)}."
        open_water = (IN_OPEN_WATER,) * (not self.prior.has_bank)
        return (*self._doubts, *self.correlated(), inertia, *self.about, *open_water, ON_TWINS)

    @property
    def _doubts(self) -> tuple[str, ...]:
        uncertain = [c for c in self.coefficients.values() if c.prior_std > 0]
        far = [c.name for c in uncertain if abs(c.value - c.prior) > MOVED_STDS * c.prior_std]
        named = f", mainly in {', '.join(far)}" if far else ""
        left = self.noise["psi"].size if "psi" in self.noise else 0.0
        strength, whole = self.gusts.strength if self.gusts else 0.0, self.whole_missed
        doubts = {
            f"Log and prior contradict each other{named}: the sum of squares is {self.disagreement:.0f}, the expected "
            f"value {self.freedom}. Check the signs of rudder and yaw rate, and whether the log is from another ship "
            "or draft. Otherwise one of the stated errors is too small.": self.disagrees,
            "The search did not converge: do not rely on these numbers.": not self.settled,
            "This model predicts the heading of left-out records less well than a nonlinear Nomoto model of the same "
            "records. Do not rely on it for manoeuvres like these.": bool(whole) and whole["after"] > whole["nomoto"],
            f"The learned model misses the heading by {np.degrees(left):.1f} deg, more than the error of a compass. "
            "Its terms do not fit this log. Check whether the log is from another ship or draft.": left >= HEADING_LEFT,
            f"Disturbances are {strength:.0f} times as strong as the prior gusts. Other ships may have passed: mark "
            "these times in the log (`meeting`). Otherwise the intervals are too narrow.": self.pushed,
        }
        return tuple(sentence for sentence, holds in doubts.items() if holds)

    def summary(self) -> str:
        """Warnings, learned coefficients, coefficients from the prior, and prediction errors."""
        gusty = "" if self.gusts is None else (
            f"Estimated gusts: {self.gusts.sway:.2g} m/s2 in sway and {self.gusts.yaw:.2g} rad/s2 in yaw (standard "
            f"deviations), with a correlation time of {self.gusts.memory:.0f} s."
        )  # fmt: skip
        return "\n".join(filter(None, (*self._doubts, self._taught(self._size), self._prediction, gusty, ON_TWINS)))

    @property
    def _prediction(self) -> str:
        before, after = np.degrees(self.missed("psi"))
        if len(self.records) < 2 or not np.isfinite([before, after]).all():
            return ""
        if self.whole_missed:
            before, after, nomoto = np.degrees(list(self.whole_missed.values()))
            return (
                f"Heading error over whole left-out records: {after:.2g} deg; {before:.2g} deg with the prior model, "
                f"{nomoto:.2g} deg with a nonlinear Nomoto model."
            )
        worse = " The log does not improve forecasts." * bool(after >= before)
        return (
            f"Heading error of forecasts over 3.5 ship lengths in left-out records: {after:.2g} deg; {before:.2g} deg "
            f"with the prior model.{worse}"
        )

    @property
    def whole_missed(self) -> dict[str, float]:
        """Root mean square over whole records of the heading missed [rad], by model; empty where gusts act."""
        rows = [record.whole for record in self.records if np.isfinite(record.whole.get("after", np.nan))]
        if len(rows) < 2:
            return {}
        return {name: float(np.sqrt(np.mean([row[name] ** 2 for row in rows]))) for name in rows[0]}

    def missed(self, state: str) -> tuple[float, float]:
        """Return the forecast errors of prior and learned model over all left-out records.

        Parameters
        ----------
        state : {"y", "psi", "r"}
            Quantity, in SI.
        """
        rows = np.array([record.missed[state] for record in self.records]).reshape(-1, 2)
        rows = rows[np.isfinite(rows).all(axis=1)]
        before, after = np.sqrt(np.mean(rows**2, axis=0)).tolist() if len(rows) else (np.nan, np.nan)
        return before, after

    def to_dict(self) -> dict[str, Any]:
        """Give everything by name: part of what ``learn --json`` prints."""
        return {
            "summary": self.summary(),
            "informative": self.informative,
            "coefficients": [coefficient.to_dict() for coefficient in self.coefficients.values()],
            "disagreement": {"sum": self.disagreement, "freedom": self.freedom, "probability": self.probability},
            "gusts": None if self.gusts is None else self.gusts._asdict(),
            "noise": {name: {"size": left.size, "outliers": left.beyond} for name, left in self.noise.items()},
            "records": [
                {name: getattr(r, name) for name in RECORD_FIELDS}
                | {"missed": {name: {"before": old, "after": new} for name, (old, new) in r.missed.items()}}
                for r in self.records
            ],
            "settled": self.settled,
            "notes": list(self.notes),
        }  # fmt: skip
