"""What each verdict is drawn from: the interval of the error model, and whether other fits agree with the one made."""

from collections.abc import Iterator
from functools import cached_property

import numpy as np

from narrows.identification.identifiability.other_estimates import Alternative, ComparedEstimate, Kind
from narrows.identification.identifiability.strata import Strata
from narrows.identification.motions import DistinctMotions
from narrows.identification.regression.problem import Problem
from narrows.identification.uncertainty.interval import t_quantile
from narrows.identification.uncertainty.unbounded_fit import ErrorModel, freedoms

# Standard errors of a difference between two fits beyond which the interval reaches over it.
SEEN = 2.0
# Half widths that this may add.
MOST_WIDENED = 2.0
# Steady runs against harmonic ones, over all of whose difference the interval reaches: a calibration, a mount or a
# rail that is another in one type of runs is shared by all of these, so that their number says nothing of it.
OF_TYPES = (Kind.TYPE, Kind.GAIN)
# Of what the fit knows, under which a type of runs by itself knows nothing of a coefficient.
LEAST_SHARE = 1 / 30
# Level at which estimates contradict each other, over how many are compared.
CONTRADICTION = 0.01
# Share of what is known that may go with one motion: without it the standard error doubles.
ONE_TEST = 0.75
# Of the interval's half width: a smaller difference contradicts nothing.
MATTERS = 0.5


class Evidence:
    """Everything that speaks for or against the coefficients of a fit."""

    def __init__(self, problem: Problem, motions: DistinctMotions, model: ErrorModel) -> None:
        self.problem, self.motions, self.model = problem, motions, model
        self.slots = [problem.slot[term.name] for term in problem.terms.terms]
        self.freedom = freedoms(problem, model)
        self.std = np.sqrt(np.maximum(np.diag(model.of_theta), 0.0))

    @cached_property
    def alternatives(self) -> list[list[Alternative]]:
        """Of each coefficient; none where the fit does not determine it."""
        strata = Strata(self.problem, self.motions, self.model)
        live = self.model.best.known & ~self.model.held
        return [list(strata.of(i)) if live[slot] else [] for i, slot in enumerate(self.slots)]

    @cached_property
    def plain(self) -> np.ndarray:
        """Half of each 95 % interval before it reaches over what other fits show, (n,)."""
        return np.asarray(t_quantile(self.counts) * self._errors[0])

    @property
    def counts(self) -> np.ndarray:
        """Degrees of freedom of each standard error, and one, (n,)."""
        return self._errors[1]

    @cached_property
    def _errors(self) -> tuple[np.ndarray, np.ndarray]:
        """Standard errors by the error model, or by what each motion moves where that reaches farther; their counts."""
        # What moves a coefficient that rests on one motion says nothing of its error, nor is it asked where runs are
        # said not to differ.
        assumed, counts = self.std[self.slots], self.freedom + 1
        if self.model.errors.none:
            return assumed, counts
        std, freedom = self.model.jackknife
        moved = np.where(self._gone_with_one > ONE_TEST, 0.0, std)[self.slots]
        fewer = freedom[self.slots] + 1
        farther = t_quantile(fewer) * moved > t_quantile(counts) * assumed
        return np.where(farther, moved, assumed), np.where(farther, fewer, counts)

    @cached_property
    def _gone_with_one(self) -> np.ndarray:
        """The largest share of what is known of each parameter that goes with one motion, (p,)."""
        least = np.full(len(self.std), np.inf)
        for one in self.model.left_out:
            variance = np.where(one.known, np.diag(one.covariance(self.model.covariance)), np.inf)
            least = np.minimum(least, self.std**2 / np.where(variance > 0, variance, np.inf))
        return np.asarray(1 - least)

    @cached_property
    def errors(self) -> np.ndarray:
        """Standard errors whose intervals reach over errors of form that are seen; tied coefficients alike, (n,)."""
        seen = np.array([self._seen(i) for i in range(len(self.slots))])
        std = self._errors[0] + seen / t_quantile(self.counts)
        slots = np.array(self.slots)
        return np.array([std[slots == slot].max() for slot in slots])

    def _seen(self, index: int) -> float:
        """By how much the interval reaches over other fits; not at all where runs do not differ."""
        # Over the farthest that is two of its errors off, within a limit; between types of runs over the difference,
        # and its own interval where that is wider than the plain one.
        if self.model.errors.none:
            return 0.0
        theta, plain = self.model.theta[self.slots[index]], float(self.plain[index])
        quantile, seen = float(t_quantile(self._scatter_count(index))), [0.0]
        for a in self.alternatives[index]:
            apart = abs(a.value - theta)
            if a.kind in OF_TYPES and self._share(a, index) > LEAST_SHARE:
                seen.append(apart + max(quantile * a.gap - plain, 0.0))
            elif apart > SEEN * a.gap:
                seen.append(min(apart, MOST_WIDENED * plain))
        return max(seen)

    def compared(self, index: int) -> Iterator[ComparedEstimate]:
        """Yield the alternatives of a coefficient beside the fit."""
        slot, alternatives = self.slots[index], self.alternatives[index]
        level = 1 - CONTRADICTION / max(len(alternatives), 1)
        limit = float(t_quantile(self._scatter_count(index), level))
        reach = float(t_quantile(self.freedom[index] + 1))
        theta, scale = self.model.theta[slot], self.problem.scale[slot]
        for a in alternatives:
            share = self._share(a, index)
            against = bool(abs(a.value - theta) > max(limit * a.gap, MATTERS * self.plain[index]))
            shown = (a.kind, a.label, a.value / scale, a.stratum)
            yield ComparedEstimate(*shown, reach * a.std / scale, share, against)

    def _share(self, other: Alternative, index: int) -> float:
        """Of what the fit knows of a coefficient, what another estimate knows."""
        return 0.0 if other.lost else float(self.std[self.slots[index]] ** 2 / other.std**2)

    def _scatter_count(self, index: int) -> float:
        """Degrees of freedom of the scatter that the data show, and one."""
        return self.model.fit[self._force(index)].freedom + 1

    def _force(self, index: int) -> int:
        parts = [part for part in self.problem.terms.forces.values() if part]
        return int(np.searchsorted(np.cumsum([len(part) for part in parts]), index, side="right"))

    def lack_of_fit(self, index: int) -> float:
        """Return the probability of as much scatter as there is in a coefficient's force [1]; NaN if unknown."""
        return self.model.fit[self._force(index)].p
