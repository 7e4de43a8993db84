"""Other fits that should agree: hulls and zeros of their own within strata, other weights, some motions alone."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from narrows.identification.identifiability.other_estimates import Alternative, Kind
from narrows.identification.motions import EDGE, DistinctMotions
from narrows.identification.regression.problem import Problem
from narrows.identification.uncertainty.error_model import covariance, pseudo_inverse, whitened
from narrows.identification.uncertainty.linear_estimator import SecondEstimate, compared_with, estimator
from narrows.identification.uncertainty.second_level import SecondLevel, in_halves
from narrows.identification.uncertainty.unbounded_fit import ErrorModel

# Share of a column that is left beside others under which it cannot be told from them.
LOST = 1e-6

OFFSET = "offset"

STEADY_RUNS, HARMONIC_RUNS = TYPES = "steady runs", "harmonic runs"

LATER = "told by the later half of each run alone"

WHERE = {"speed": "runs at {:.3g} m/s", "depth": "runs in {:.4g} m of water"}

# Of the offset, its sign kept, as which a force may go that is no bank's; as y itself a bank's goes.
POWERS = (1.5, 2, 3)

# How often columns are projected: the second time takes off what rounding left the first time.
TWICE = 2

# Share of a column that is in a cell up to which it is not there at all.
ABSENT = 1e-12

# The same of a column that is added: under it what is left is rounding.
RESOLVED = 1e-8


class Strata:
    """Alternatives to a fit, made when they are asked for and shared between coefficients where they are the same."""

    def __init__(self, problem: Problem, motions: DistinctMotions, model: ErrorModel) -> None:
        self.problem, self.motions, self.model = problem, motions, model
        self.level: SecondLevel = model.level
        self.terms = problem.terms.terms
        self.bank = np.array([term.from_bank for term in self.terms])
        self.operator = self.level.d @ model.best.inverse.T
        self.shown, self.v = model.shown, model.covariance
        self.slots = np.array([problem.slot[term.name] for term in self.terms])
        self._kept: dict[str, list[np.ndarray | None]] = {}

    def of(self, index: int) -> Iterator[Alternative]:
        """Yield every alternative estimate of a coefficient."""
        slot = self.problem.slot[self.terms[index].name]
        for name in self.motions.cells:
            label = f"hull terms and zeros of their own at each {name}"
            yield self._made(Kind.STRATA, label, slot, self._in_strata(name, index))
        if self.motions.offsets.max() > 0:
            at_each = self._in_strata(OFFSET, index)
            yield self._made(Kind.STRATA, "hull terms of their own at each offset", slot, at_each)
        yield self._made(Kind.STRATA, "a constant force beside", slot, self._beside(slot, self._constants))
        for kind, label, other in self._of_all:
            value = float(other.values[slot]) if other.known[slot] else np.nan
            if other.known[slot] or kind is not Kind.ONLY:
                yield Alternative(kind, label, value, None, float(other.std[slot]), float(other.gap[slot]))
        if self.bank[index]:
            yield from self._of_bank(index, slot)
        yield from self._of_parts(index, slot)

    def _of_bank(self, index: int, slot: int) -> Iterator[Alternative]:
        """Beside a force that grows otherwise with the offset."""
        for power in POWERS:
            beside = self._beside(slot, self._added(self._as_power(index, power)))
            yield self._made(Kind.SHAPE, f"a force that goes as y^{power} beside", slot, beside)

    def _of_parts(self, index: int, slot: int) -> Iterator[Alternative]:
        """Told by some motions alone, and with a gain of some motions."""
        for name, mask, stratum in self._parts():
            part = self._only(slot, index, mask)
            if part is not None:
                kind = Kind.TYPE if name in TYPES else Kind.ONLY
                yield self._made(kind, f"told by {name} alone", slot, part, stratum)
        for name, gain in self._gains.items():
            part = self._beside(slot, gain)
            if part is not None:
                yield self._made(Kind.GAIN, f"a gain of their own in {name}", slot, part)

    def _made(
        self, kind: Kind, label: str, slot: int, weights: np.ndarray | None, stratum: tuple[str, float] | None = None
    ) -> Alternative:
        if weights is None:
            return Alternative(kind, label, np.nan, stratum, np.inf, np.inf)
        change = weights - self.operator[..., slot]
        value = float((weights * self.level.y).sum())
        return Alternative(kind, label, value, stratum, _size(weights, self.v), _size(change, self.shown))

    @cached_property
    def _of_all(self) -> list[tuple[Kind, str, SecondEstimate]]:
        """The fit weighted by the error model, without each motion, and to later halves, of all parameters at once."""
        level = self.level
        white = whitened(self.v, level.d)
        root = np.linalg.cholesky(self.v)
        instruments = np.linalg.solve(np.swapaxes(root, 1, 2), white)
        others = [(Kind.WEIGHTS, "motions weighted by their errors", estimator(instruments, level.d))]
        pairs = zip(self.motions.labels, self.model.left_out, strict=True)
        others += [(Kind.WITHOUT, label, one) for label, one in pairs]
        errors = level.y, self.v, self.shown
        compared = [(kind, label, compared_with(self.operator, one, *errors)) for kind, label, one in others]
        return [*compared, (Kind.ONLY, LATER, of_later_half(self.problem, self.motions, self.model))]

    def _in_strata(self, name: str, index: int) -> np.ndarray | None:
        """Weights of the estimate beside hull terms and zeros of each cell of a stratification."""
        if name not in self._kept:
            z, live = self._within(name)
            inverse, known = pseudo_inverse(_products(z))
            weights = (z @ inverse[:, None, :, :1])[..., 0]
            determined = live & known[:, 0]
            self._kept[name] = [each if good else None for each, good in zip(weights, determined, strict=True)]
        return self._kept[name][index]

    def _within(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """What is left of each coefficient's column, and of the bank's, beside hull terms and zeros of each cell."""
        # (n, blocks, q, c), its own first; and whether anything is left of that, (n,). Other hull columns are sums of
        # those beside: nothing is left of them.
        level, (beside, of_terms) = self.level, self._hulls
        group = self.motions.offsets if name == OFFSET else self.motions.cells[name]
        cell = group[level.motion] * level.forces + level.force
        cells = np.arange(cell.max() + 1)
        inside = (cell == cells[:, None]).astype(float)
        turned = np.swapaxes(beside, 1, 2)

        def summed(columns: np.ndarray) -> np.ndarray:
            parts = turned @ columns
            flat = inside @ parts.reshape(*parts.shape[:-2], -1)
            return np.asarray(flat.reshape(*flat.shape[:-1], *parts.shape[-2:]))

        inverse = self._inverses(summed(beside), of_terms[cells % level.forces], zeros=name != OFFSET)
        columns = self._columns
        left = columns
        for _ in range(TWICE):
            left = left - beside @ (inverse @ summed(left))[:, cell]
        whole, rest = (columns**2).sum(axis=(1, 2)), (left**2).sum(axis=(1, 2))
        live = rest > LOST * whole
        return np.asarray(left * live[:, None, None]), live[:, 0]

    def _inverses(self, gram: np.ndarray, of_terms: np.ndarray, zeros: bool) -> np.ndarray:
        """Of the products of what is beside each coefficient in each cell, (n, cells, k, k): its own column is not."""
        hull, count = ~self.bank, len(self.terms)
        kept = np.append(hull, zeros)[of_terms] & (of_terms >= 0)
        apart = np.ones((count, count + 1), bool)
        apart[:, :-1] = self.bank[:, None] | (self.slots[:, None] != self.slots)
        inverse = np.repeat(pseudo_inverse(_masked(gram, kept), ABSENT)[0][None], count, axis=0)
        term, cell = np.nonzero((kept & ~apart[:, of_terms]).any(axis=2))
        left = kept[cell] & apart[term[:, None], of_terms[cell]]
        inverse[term, cell] = pseudo_inverse(_masked(gram[cell], left), ABSENT)[0]
        return inverse

    @cached_property
    def _hulls(self) -> tuple[np.ndarray, np.ndarray]:
        """Columns of hull terms and of a zero, force by force, (blocks, q, k); of which term each is, (forces, k)."""
        # The zero's number is that of the terms; -1 where there is none.
        level = self.level
        return _of_own_force(np.concatenate([level.columns * ~self.bank, level.one[..., None]], axis=2), level.force)

    @cached_property
    def _columns(self) -> np.ndarray:
        """The column of each coefficient's parameter and those of the bank's others, (n, blocks, q, c)."""
        banks = np.unique(self.slots[self.bank])
        empty = np.concatenate([self.level.d, np.zeros((*self.level.y.shape, 1))], axis=2)
        chosen = [[slot, *np.where(banks == slot, -1, banks)] for slot in self.slots]
        return np.asarray(np.moveaxis(empty[..., np.array(chosen)], 2, 0))

    @cached_property
    def _constants(self) -> "_Added":
        return self._added(self._of_each_force(self.level.one))

    @cached_property
    def _gains(self) -> "dict[str, _Added]":
        """The fitted force of steady motions, and of harmonic ones: their gain; none where all are of one kind."""
        level, steady = self.level, self.motions.steady
        if steady.all() or not steady.any():
            return {}
        fitted = level.d @ self.model.theta
        kinds = {STEADY_RUNS: steady, HARMONIC_RUNS: ~steady}
        return {
            name: self._added(self._of_each_force(fitted * mask[level.motion][:, None])) for name, mask in kinds.items()
        }

    def _of_each_force(self, column: np.ndarray) -> np.ndarray:
        """A column (blocks, q) as one for each force."""
        level = self.level
        return np.asarray(column[..., None] * (level.force[:, None] == np.arange(level.forces))[:, None, :])

    def _as_power(self, index: int, power: float) -> np.ndarray:
        """The coefficient's own column as it grows from motion to motion with an offset, to a power less one."""
        level = self.level
        grown = self.motions.cube[level.motion] ** ((power - 1) / 2)
        return np.asarray(level.columns[..., index, None] * grown[:, None, None])

    def _added(self, z: np.ndarray) -> "_Added":
        """Columns z that are added to the fit: what is left of them beside its own, brought to directions."""
        flat = z.reshape(-1, z.shape[2])
        columns = self.level.d.reshape(len(flat), -1)
        left = flat
        for _ in range(TWICE):
            left = left - columns @ (self.model.best.inverse @ (columns.T @ left))
        size = np.where((flat**2).sum(axis=0) > 0, np.sqrt((flat**2).sum(axis=0)), 1.0)
        values, vectors = np.linalg.eigh((left / size).T @ (left / size))
        kept = values > RESOLVED
        return _Added(flat / size, vectors[:, kept], (left / size) @ (vectors[:, kept] / values[kept]))

    def _beside(self, slot: int, added: "_Added") -> np.ndarray | None:
        """Weights of the estimate with columns z added: w - (w z) (z'Mz)^- z'M (Frisch, Waugh, Lovell)."""
        w = self.operator[..., slot]
        taken = w.ravel() @ added.columns
        inside = taken @ added.directions
        outside = np.linalg.norm(taken - added.directions @ inside)
        if outside > 1e-3 * max(float(np.linalg.norm(taken)), 1e-3 * float(np.linalg.norm(w))):
            return None
        return np.asarray(w - (added.left @ inside).reshape(w.shape))

    def _parts(self) -> Iterator[tuple[str, np.ndarray, tuple[str, float] | None]]:
        motions = self.motions
        yield STEADY_RUNS, motions.steady, None
        yield HARMONIC_RUNS, ~motions.steady, None
        reach = motions.reach
        yield "motions far from the walls", reach <= EDGE * 0.5 * (reach.max() + np.median(reach)), None
        for name in ("speed", "depth"):
            group = motions.strata[name]
            for number in range(group.max() + 1) if group.max() else ():
                mean = float(f"{motions.features[name][group == number].mean():.6g}")
                yield WHERE[name].format(mean), group == number, (name, mean)

    def _only(self, slot: int, index: int, mask: np.ndarray) -> np.ndarray | None:
        """Weights of the estimate with a coefficient of its own for the other motions."""
        column = self.level.columns[..., index]
        inside = mask[self.level.motion][:, None]
        here, there = column * inside, column * ~inside
        if not (here**2).sum() > 0 or not (there**2).sum() > 0:
            return None
        return self._beside(slot, self._added(there[..., None]))


@dataclass(frozen=True)
class _Added:
    """Columns added to a fit, of unit length; directions among them that it does not hold; what is left in these."""

    columns: np.ndarray
    directions: np.ndarray
    left: np.ndarray


def _of_own_force(columns: np.ndarray, force: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Leave out the columns that are zero in every block of a force; and say which ones each force has."""
    live = [np.flatnonzero(columns[force == f].any(axis=(0, 1))) for f in range(force.max() + 1)]
    width = max(1, *(len(index) for index in live))
    packed, chosen = np.zeros((*columns.shape[:2], width)), np.full((len(live), width), -1)
    for f, index in enumerate(live):
        packed[force == f, :, : len(index)] = columns[force == f][..., index]
        chosen[f, : len(index)] = index
    return packed, chosen


def _masked(gram: np.ndarray, kept: np.ndarray) -> np.ndarray:
    return np.asarray(gram * kept[..., :, None] * kept[..., None, :])


def _products(z: np.ndarray) -> np.ndarray:
    flat = z.reshape(len(z), -1, z.shape[-1])
    return np.asarray(np.swapaxes(flat, 1, 2) @ flat)


def _size(weights: np.ndarray, v: np.ndarray) -> float:
    return float(np.sqrt(max((weights * (v @ weights[..., None])[..., 0]).sum(), 0.0)))


# The fit to the later half of each run: forces that settle, and gauges that drift within a run, make it another.
def of_later_half(problem: Problem, motions: DistinctMotions, model: ErrorModel) -> SecondEstimate:
    """Compare the fit with that to the later half of each run."""
    # Both halves have a run's gain and zero, so that these do not part the two fits; a form error of each half does.
    level = in_halves(model.level, motions, problem).less(model.theta, model.held)
    later = level.d.copy()
    later[:, : model.level.d.shape[1]] = 0.0
    fitted = level.d @ model.theta
    v, shown = (covariance(level, fitted, model.errors, factor) for factor in (model.factor, model.factor_shown))
    return compared_with(level.d @ model.best.inverse.T, estimator(later), level.y, v, shown)
