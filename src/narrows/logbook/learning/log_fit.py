"""Result of learning from a log: learned coefficients, prior coefficients, errors of forecasts."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from narrows.logbook.learned_coefficient import LEARNED, ON_TWINS, PRIOR, LearnedAnswer, LearnedCoefficient, pairs
from narrows.logbook.learning.record_answers import RecordAnswer
from narrows.model.model import Model

# What stands beside the label of this room where no bank is felt.
IN_OPEN_WATER = "Identification in open water is held to measured manoeuvres."
# Probability under which log and prior are said to disagree.
UNLIKELY = 1e-3
# Times the usual gusts, from which pushes are said to be none: of twins in gusts alone one in fifty comes so far.
STRONG = 4.0
# Residual noise of headings [rad] that exceeds the error of a compass.
HEADING_LEFT = np.radians(0.5)
# Standard deviations before, from which a coefficient is named.
FAR = 3.0


@dataclass(frozen=True)
class Gusts:
    """Pushes with a memory, as the records make them most likely."""

    sway: float  # Standard deviation of the acceleration [m/s2]
    yaw: float  # Likewise [rad/s2]
    memory: float  # How long they stay [s]
    correlation: float  # Between the two [1]
    strength: float  # Gusts over their prior size, in sway or in yaw, whichever is more [1]


@dataclass(frozen=True)
class SignalNoise:
    """White noise of a signal."""

    size: float  # Standard deviation of a reading [unit of the signal]
    beyond: float  # Share of readings that count less as outliers [1]


@dataclass(frozen=True, repr=False)
class LogFit(LearnedAnswer):
    """Result of learning from a log.

    Parameters
    ----------
    model : Model
        The model that comes out.
    prior : Model
        The model before, with the covariance that it was given.
    coefficients : mapping of str to LearnedCoefficient
        Each before and after.
    records : tuple of RecordAnswer
        What each record did.
    gusts : Gusts, optional
        None where none were looked for.
    noise : mapping of str to SignalNoise
        Most likely noise of a reading of each signal.
    disagreement : float [1]
        Square of how far the log moved the coefficients, over what was to be expected.
    freedom : int
        Number of combinations of coefficients that the log determines.
    probability : float [1]
        Probability of at least such a disagreement where log and prior are of one ship.
    held : tuple of str
        Coefficients of inertia that the log left as they were: they fix the others, as motion determines only ratios.
    about : tuple of str
        What was taken for granted, and what was left out.
    settled : bool
        Whether the search came to rest.
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

    def __repr__(self) -> str:
        return f"<LogFit of {self.model.ship.name}: {self._size}>"

    @property
    def _size(self) -> str:
        hours = sum(record.duration for record in self.records) / 3600
        lasting = f"{hours:.3g} h" if hours >= 1 else f"{60 * hours:.3g} min"
        return f"{len(self.records)} {'record' if len(self.records) == 1 else 'records'}, {lasting}"

    @property
    def tells(self) -> bool:
        """True where the log determined a coefficient: one of the bank, where the model has one."""
        asked = [c for c in self.coefficients.values() if c.from_bank or not self.prior.feels_bank]
        return any(c.word == LEARNED for c in asked)

    @property
    def disagrees(self) -> bool:
        """True where log and prior contradict each other."""
        return self.probability < UNLIKELY

    @property
    def pushed(self) -> bool:
        """True where disturbances are too strong for gusts, as with passing ships that the log lacks."""
        return self.gusts is not None and self.gusts.strength > STRONG

    @property
    def notes(self) -> tuple[str, ...]:
        """Contradictions, inseparable pairs, assumptions, left-out records, and coefficients that fix the rest."""
        together = [
            f"{name} goes with {other} (correlation {by:+.2f}): together they are known better than either."
            for name, other, by in pairs(self.coefficients, np.asarray(self.model.covariance))
        ]
        inertia = (
            f"Motion determines only forces over inertia: {', '.join(self.held)} "
            f"{'holds' if len(self.held) == 1 else 'hold'} the rest, as before the log."
        )
        open_water = (IN_OPEN_WATER,) * (not self.prior.feels_bank)
        return (*self._doubts, *together, inertia, *self.about, *open_water, ON_TWINS)

    @property
    def _doubts(self) -> tuple[str, ...]:
        return (*self._disagreement, *self._search, *self._simpler, *self._left, *self._pushed)

    @property
    def _search(self) -> tuple[str, ...]:
        return ("The search did not come to rest; take the numbers with care.",) * (not self.settled)

    @property
    def _left(self) -> tuple[str, ...]:
        if "psi" not in self.noise or self.noise["psi"].size < HEADING_LEFT:
            return ()
        left = np.degrees(self.noise["psi"].size)
        return (
            f"The model after the log still misses the heading by {left:.1f} deg, more than a compass errs: its "
            "terms do not follow this log, as where that is of another ship or draft.",
        )

    @property
    def _disagreement(self) -> tuple[str, ...]:
        if not self.disagrees:
            return ()
        far = [c for c in self.coefficients.values() if c.prior_std > 0 and abs(c.value - c.prior) > FAR * c.prior_std]
        named = f", most of all {', '.join(c.name for c in far)}" if far else ""
        return (
            f"The log and what was known before disagree{named}: a sum of squares of {self.disagreement:.0f}, "
            f"{self.freedom} expected. One of them errs, their errors are larger than they say, the rudder or the yaw "
            "rate of the log counts the other way, or the log is of another ship or draft.",
        )

    @property
    def _pushed(self) -> tuple[str, ...]:
        if self.gusts is None or not self.pushed:
            return ()
        return (
            f"Pushes come out {self.gusts.strength:.0f} times as strong as gusts usually are, as where other ships "
            "pass: mark these times in the log (`meeting`), for intervals do not hold where such pushes are taken for "
            "gusts.",
        )

    def summary(self) -> str:
        """Doubts, what was learned, what still comes from the prior, and the errors of prediction."""
        bank = [c for c in self.coefficients.values() if c.from_bank and c.prior_std > 0]
        learned = [c.name for c in self.coefficients.values() if c.word == LEARNED and not c.from_bank]
        open_still = [c.name for c in self.coefficients.values() if c.word == PRIOR and c.prior_std > 0]
        told = [c.sentence() for c in bank if c.word != PRIOR]
        told += [f"learned: {', '.join(learned)}"] if learned else []
        first = f"Learned from {self._size}: {'; '.join(told) or 'nothing'}."
        rest = f" From the prior still: {', '.join(open_still)}." if open_still else ""
        return "\n".join(filter(None, (*self._doubts, first + rest, self._prediction, self._gusty, ON_TWINS)))

    @property
    def _prediction(self) -> str:
        before, after = self.missed("psi")
        if len(self.records) < 2 or not np.isfinite([before, after]).all():
            return ""
        if self.whole_missed:
            before, after, nomoto = np.degrees(list(self.whole_missed.values()))
            return (
                f"Whole records under their recorded rudder, each left out in turn: heading missed by {after:.2g} deg, "
                f"{before:.2g} deg by the model before, {nomoto:.2g} deg by a nonlinear Nomoto model."
            )
        words = f"Forecasts over 3.5 ship lengths miss the heading by {np.degrees(after):.2g} deg"
        worse = ": the log made them no better" * (after >= before)
        return f"{words} on records that were left out, {np.degrees(before):.2g} deg before{worse}."

    @property
    def _gusty(self) -> str:
        if self.gusts is None:
            return ""
        return (
            f"Gusts of {self.gusts.sway:.2g} m/s2 and {self.gusts.yaw:.2g} rad/s2 that stay {self.gusts.memory:.0f} s "
            "act beside the model (standard deviations)."
        )

    @property
    def whole_missed(self) -> dict[str, float]:
        """Root mean square over whole records of the heading missed [rad], by model; empty where gusts act."""
        rows = [record.whole for record in self.records if {"before", "after", "nomoto"} <= record.whole.keys()]
        rows = [row for row in rows if np.isfinite(row["after"])]
        if len(rows) < 2:
            return {}
        return {
            name: float(np.sqrt(np.mean([row[name] ** 2 for row in rows]))) for name in ("before", "after", "nomoto")
        }

    @property
    def _simpler(self) -> tuple[str, ...]:
        told = self.whole_missed
        if not told or told["after"] <= told["nomoto"]:
            return ()
        return (
            "This model predicts the heading of left-out records worse than a nonlinear Nomoto model fitted to the "
            "same records: do not rely on it for manoeuvres like these.",
        )

    def missed(self, state: str) -> tuple[float, float]:
        """Return what forecasts miss over all records, before and after, each record left out in turn.

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
            "tells": self.tells,
            "coefficients": [coefficient.to_dict() for coefficient in self.coefficients.values()],
            "disagreement": {"sum": self.disagreement, "freedom": self.freedom, "probability": self.probability},
            "gusts": None if self.gusts is None else vars(self.gusts),
            "noise": {name: {"size": left.size, "outliers": left.beyond}
                      for name, left in self.noise.items()},
            "records": [
                {"name": r.name, "duration": r.duration, "steps": r.steps, "met": r.met, "zeros": r.zeros,
                 "information": r.information, "moved": r.moved, "whole": dict(r.whole),
                 "missed": {name: {"before": old, "after": new} for name, (old, new) in r.missed.items()}}
                for r in self.records
            ],
            "settled": self.settled,
            "notes": list(self.notes),
        }  # fmt: skip
