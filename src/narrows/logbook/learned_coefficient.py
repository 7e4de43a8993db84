"""Coefficients before and after a log, with a verdict on each."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from narrows.base.errors import InputError, shown
from narrows.base.results import Aliased, BaseResult, Named
from narrows.identification.verdict import IDENTIFIED
from narrows.logbook.settings import LEARNED_TO, SHARPENED_TO
from narrows.model.data_range import DataRange, Range
from narrows.model.model import Model

LEARNED, SHARPENED, PRIOR, UNRESOLVED = "learned", "sharpened", "from the prior", "unresolved"
QUANTILE_95 = 1.959964  # Half-width of the central 95 % of a normal distribution [standard errors]


@dataclass(frozen=True)
class LearnedCoefficient(Aliased):
    """A coefficient before a record and after it."""

    name: str
    unit: str
    prior: float  # Value before
    prior_std: float  # Standard error before
    value: float  # Value after
    std: float  # Standard error after
    from_bank: bool  # Whether its term is one of the bank

    @property
    def std_ratio(self) -> float:
        """Standard error over the one before; 1 where that was 0."""
        return self.std / self.prior_std if self.prior_std > 0 else 1.0

    @property
    def interval(self) -> tuple[float, float]:
        """95 % interval after."""
        return self.value - QUANTILE_95 * self.std, self.value + QUANTILE_95 * self.std

    @property
    def likelihood_interval(self) -> tuple[float, float]:
        """95 % interval by the record alone, the prior of this coefficient removed; infinite without information."""
        before, after = (1 / std**2 if std > 0 else math.inf for std in (self.prior_std, self.std))  # Precisions
        if not before < after < math.inf:
            return -math.inf, math.inf
        gained = after - before
        value = (self.value * after - self.prior * before) / gained
        return value - QUANTILE_95 / math.sqrt(gained), value + QUANTILE_95 / math.sqrt(gained)

    @property
    def unresolved(self) -> bool:
        """True if the interval contains 0; for a learned coefficient also if that of the record alone does."""
        intervals = (self.interval, self.likelihood_interval) if self.status == LEARNED else (self.interval,)
        return any(low <= 0 <= high for low, high in intervals)

    @property
    def status(self) -> str:
        """``learned``, ``sharpened`` or ``from the prior``."""
        return LEARNED if self.std_ratio <= LEARNED_TO else SHARPENED if self.std_ratio <= SHARPENED_TO else PRIOR

    @property
    def verdict(self) -> str:
        """The status; for a bank coefficient that may be 0 also ``unresolved``."""
        return f"{self.status}, {UNRESOLVED}" if self.from_bank and self.unresolved else self.status

    def to_dict(self) -> dict[str, Any]:
        known = {"prior": self.prior, "prior_std": self.prior_std, "value": self.value, "std": self.std}
        return {"name": self.name, "unit": self.unit, **known, "interval": list(self.interval), "verdict": self.verdict}

    def sentence(self) -> str:
        low, high = self.interval
        words = f"{self.name} is {low:.3g} to {high:.3g} (standard error {self.std:.2g}, {self.prior_std:.2g} before)"
        if not (self.from_bank and self.unresolved):
            return words
        own_low, own_high = self.likelihood_interval
        among = "0 is among it" if low <= 0 <= high else f"by the record alone it is {own_low:.3g} to {own_high:.3g}"
        return f"{words}: unresolved, for {among}"


@dataclass(frozen=True, repr=False)
class LearnedAnswer(BaseResult):
    model: Model  #: The model after the record
    prior: Model  #: The model before
    coefficients: Mapping[str, LearnedCoefficient]  #: Each before and after

    @property
    def std(self) -> dict[str, float]:
        """Standard error of each coefficient."""
        return {name: c.std for name, c in self.coefficients.items()}

    @property
    def intervals(self) -> dict[str, tuple[float, float]]:
        """95 % interval of each coefficient."""
        return {name: c.interval for name, c in self.coefficients.items()}

    @property
    def verdicts(self) -> dict[str, str]:
        """Verdict on each coefficient, in a word or two."""
        return {name: c.verdict for name, c in self.coefficients.items()}

    def to_dataframe(self) -> pd.DataFrame:
        """Give the coefficients as a table: a row each, before and after."""
        known = self.coefficients
        rows = [
            (c.prior, c.prior_std, c.value, c.std, *c.interval, c.std_ratio, c.unit, c.verdict) for c in known.values()
        ]
        columns = ["prior", "prior_std", "value", "std", "low", "high", "std_left", "unit", "verdict"]
        return pd.DataFrame(rows, columns=columns, index=pd.Index(list(known), name="coefficient"))

    def _learned_sentence(self, source: str) -> str:
        """Return a sentence on learned and unchanged coefficients."""
        known = [c for c in self.coefficients.values() if c.prior_std > 0]
        sentences = [c.sentence() for c in known if c.from_bank and c.status != PRIOR]
        learned = [c.name for c in known if c.status == LEARNED and not c.from_bank]
        sentences += [f"learned: {', '.join(learned)}"] * bool(learned)
        unchanged = ", ".join(c.name for c in known if c.status == PRIOR)
        rest = f" Unchanged from the prior: {unchanged}." if unchanged else ""
        return f"Learned from {source}: {'; '.join(sentences) or 'nothing'}.{rest}"


def learnable(model: Model, targets: object) -> tuple[str, ...]:
    names = (targets,) if isinstance(targets, str) else targets
    if not isinstance(names, tuple | list):
        raise InputError(f"targets = {shown(targets)}: give names of coefficients")
    for name in names:
        model[str(name)]  # Raises where there is none
    names = tuple(names) or tuple(term.name for term in model.terms.terms if term.from_bank)
    if not names:
        raise InputError("this model has no terms of the bank to learn; name the coefficients that matter as targets")
    return names


# Note on every page, result and report.
ON_TWINS = "Bank coefficients from legs and transits are tested on simulated twins only."


def learned_model(
    prior: Model, values: np.ndarray, covariance: np.ndarray, source: str, offsets: np.ndarray, speeds: np.ndarray,
    contradicted: bool = False,
) -> tuple[Model, dict[str, LearnedCoefficient]]:  # fmt: skip
    # values (n,); covariance (n, n); offsets [m] and speeds [m/s] of the record
    before, after = (np.sqrt(np.maximum(np.diag(each), 0.0)) for each in (np.asarray(prior.covariance), covariance))
    columns = zip(prior.terms.terms, *(part.tolist() for part in (before, values, after)), strict=True)
    learned = {
        term.name: LearnedCoefficient(
            term.name, term.dimension.unit, prior.coefficients[term.name], known, value, std, term.from_bank
        )
        for term, known, value, std in columns
    }
    by_record = {True: f"{UNRESOLVED} by the ship's own record", False: IDENTIFIED}
    verdicts = {
        name: "contradicted by the ship's own record" if contradicted else by_record[UNRESOLVED in c.verdict]
        for name, c in learned.items() if c.status == LEARNED
    }  # fmt: skip
    model = replace(
        prior,
        coefficients=Named({name: c.value for name, c in learned.items()}),
        covariance=(covariance + covariance.T) / 2,
        data_range=covered_range(prior, *((float(part.min()), float(part.max())) for part in (offsets, speeds))),
        source=replace(prior.source, text="; ".join(filter(None, (prior.source.text, source)))),
        verdicts={**prior.verdicts, **verdicts},
    )
    return model, learned


def covered_range(prior: Model, offsets: Range, speeds: Range) -> DataRange:
    # offsets [m]; speeds [m/s]
    # In a section without tests only the record gives the covered offsets and speeds; at lower speeds the bank's force
    # is smaller. Without a bank only speeds count.
    known, configuration, (low, high) = prior.data_range, prior.configuration, prior.data_range.speed or speeds
    section = {"width_to_beam": configuration.canal.width / configuration.ship.beam}
    if configuration.canal.depth is not None:
        section["depth_to_draft"] = configuration.canal.depth / configuration.ship.draft
    speed = min(speeds[0], low), max(speeds[1], high)
    if not prior.has_bank:
        return replace(known, speed=speed)
    if any(getattr(known, name) is None or known.outside(name, ratio) for name, ratio in section.items()):
        here = {name: (ratio, ratio) for name, ratio in section.items()}
        return replace(known, speed=(speed[0], speeds[1]), abs_y=(0.0, offsets[1]), **here)
    nearest, farthest = known.abs_y or offsets
    return replace(known, speed=speed, abs_y=(min(offsets[0], nearest), max(offsets[1], farthest)))
