"""Fisher information of a planned run: its columns as a few rows for each force, with run errors."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from narrows.captive.settings import FORCE_NOISE
from narrows.captive.synthetic import Run, StraightRun, motion_of, twin
from narrows.errors import InputError
from narrows.identification.estimates import joint_forces
from narrows.identification.fit import Fit
from narrows.identification.force_rows import ForceRows
from narrows.identification.least_squares import free_parameters, reduced
from narrows.identification.motions import distinct_motions
from narrows.identification.normal_equations import NormalEquations, accumulate
from narrows.identification.systematic_effects import RunErrors, assemble
from narrows.model.model import Model
from narrows.ship.particulars import Configuration
from narrows.terms.term import TermTable

# Sampling rate [Hz]; a run's information depends on its noise per time, not on its sampling rate.
RATE = 5.0

# Zero offsets: of harmonic runs, of steady ones to starboard and to port, often made on different days.
ZEROS = 3


@dataclass(frozen=True)
class PlannedRun:
    """Summary of a run: ``y = D theta + error`` in a few rows for each force."""

    d: np.ndarray  # (forces, q, p) Columns of the parameters
    one: np.ndarray  # (forces, q) Column of a constant force
    v: np.ndarray  # (forces, q, q) Covariance of the rows; ones on the diagonal of empty ones
    zero: int  # Index of its zero: 0 for harmonic runs, 1 for steady ones to starboard, 2 to port

    @cached_property
    def gram(self) -> np.ndarray:
        """D'D, (p, p)."""
        return np.asarray(np.einsum("fqi,fqj->ij", self.d, self.d))

    @cached_property
    def information(self) -> np.ndarray:
        """Information (p + zeros, p + zeros), with unknown zeros of each force and kind of run."""
        forces = np.arange(len(self.one))
        zeros = np.zeros((*self.one.shape, len(forces) * ZEROS))
        zeros[forces, :, forces * ZEROS + self.zero] = self.one
        white = np.linalg.solve(np.linalg.cholesky(self.v), np.concatenate([self.d, zeros], axis=2))
        return np.asarray(np.einsum("fqi,fqj->ij", white, white))


def zero_of(steady: np.ndarray, offset: np.ndarray) -> np.ndarray:
    """Return the index of each run's zero, as in ``PlannedRun``."""
    # steady (runs,); offset (runs,) [m]
    return np.asarray(np.where(steady, np.where(offset >= 0, 1, 2), 0))


def planned_run(
    run: Run, configuration: Configuration, terms: TermTable, truth: Model, level: Mapping[str, float],
    noise: Mapping[str, float] = FORCE_NOISE, correlation_time: float = 0.5, errors: RunErrors | None = None,
) -> PlannedRun:  # fmt: skip
    """Compute the information of one run."""
    # Gain errors are proportional to the forces of truth; level [N, N, N m]; noise [N, N, N m]; correlation_time [s]
    errors = errors or RunErrors()
    columns = run.columns(RATE)
    motion, rows = motion_of(columns), len(columns["t"])
    depth = {} if run.depth is None else {"depth": run.depth}
    values = {**configuration.values(), **motion.values(), **depth}
    for name in terms.inputs:
        if name not in values:
            raise InputError(f"the terms need {name}, which the ship file does not give; add it")
    fitted = {force: part for force, part in terms.forces.items() if part}
    width = 1 + max(len(part) for part in fitted.values())
    slot, expected = free_parameters(terms), truth.forces(motion)
    d = np.zeros((len(fitted), width, max(slot.values()) + 1))
    one, v = np.zeros(d.shape[:2]), np.tile(np.eye(width), (len(fitted), 1, 1))
    for i, (force, part) in enumerate(fitted.items()):
        a = np.array([*(np.broadcast_to(term.column(values), rows) for term in part), np.ones(rows)])
        root, inverse, live = _root(a @ a.T)
        q = len(live)
        for j, term in enumerate(part):
            d[i, :q, slot[term.name]] += root[:, j]
        one[i, :q] = root[:, -1]
        force_of_run = np.broadcast_to(np.asarray(expected.get(force, 0.0), float), rows)
        fitted = inverse @ (a @ force_of_run)
        within = noise[force] ** 2 * max(1.0, 2 * correlation_time * RATE)
        within += errors.form**2 * float(force_of_run @ force_of_run) / max(int(live.sum()), 1)
        v[i, :q, :q] = (
            errors.gain**2 * np.outer(fitted, fitted)
            + (errors.zero * level.get(force, 0.0)) ** 2 * np.outer(one[i, :q], one[i, :q])
            + np.diag(np.where(live, within, 1.0))
        )
    zero = zero_of(np.array(isinstance(run, StraightRun)), np.array(np.mean(columns["y"])))
    return PlannedRun(d, one, v, int(zero))


# Share of the largest eigenvalue of scaled products: below it a direction is rounding.
DIRECTION = 1e-9


def _eigen(gram: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Sizes of columns by their products (k, k), then eigenvalues, eigenvectors and which hold data, of unit sizes."""
    size = np.sqrt(np.maximum(np.diag(gram), 0.0))
    unit = np.where(size > 0, size, 1.0)
    values, vectors = np.linalg.eigh(gram / np.outer(unit, unit))
    return size, values, vectors, values > DIRECTION * max(values[-1], 1e-300)


def _root(gram: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Factor products, H = R'R: R (k, k), its left inverse for H z = g, and which rows have data."""
    size, values, vectors, live = _eigen(gram)
    root = np.sqrt(np.where(live, values, 0.0))[:, None]
    turned = vectors.T * (size > 0)  # An empty column stays exactly zero
    inverse = np.where(live[:, None], turned / np.where(live[:, None], root, 1.0), 0.0)
    return root * turned * size, inverse / np.where(size > 0, size, 1.0), live


def inflation(runs: Sequence[PlannedRun], known: np.ndarray | None = None) -> np.ndarray:
    """Variance inflation of each parameter under some runs, (p,); infinite if they do not determine it."""
    # known (p + zeros, p + zeros): information of earlier tests
    gram = np.sum([run.gram for run in runs], axis=0)
    if known is not None:
        gram = gram + known[: len(gram), : len(gram)]
    size, values, vectors, live = _eigen(gram)
    share = vectors**2 * live
    determined = (share.sum(axis=1) > 1 - 1e-5) & (size > 0)
    return np.where(determined, (share / np.where(live, values, 1.0)).sum(axis=1), np.inf)


# The best few of many runs for some coefficients under any form of the bank: greedy choice, then exchanges.
CRITERIA = ("c", "d")

ROUNDS = 20

# Prior information relative to the largest of each parameter: almost none.
RIDGE = 1e-9

# Relative difference of the criterion within which runs count as equal: while a parameter is unknown, rounding over the
# ridge moves the criterion by about 1e-5.
TIE = 1e-4


def spread(information: np.ndarray, targets: Sequence[int], criterion: str) -> np.ndarray:
    """Return the criterion to minimise, for each of a stack of information matrices, under the worst form."""
    # information (..., forms, p, p)
    covariance = np.linalg.inv(information)[..., np.array(targets)[:, None], np.array(targets)]
    if criterion == "c":
        return np.asarray(np.trace(covariance, axis1=-2, axis2=-1).max(axis=-1))
    return np.asarray(np.linalg.slogdet(covariance)[1].max(axis=-1))


def choose(runs: np.ndarray, known: np.ndarray, count: int, targets: Sequence[int], criterion: str = "c") -> list[int]:
    """Choose runs, each at most once, in the order of their use."""
    # runs (n, forms, p, p); known (forms, p, p). Fedorov (1972), Theory of optimal experiments: the exchange.
    scale = np.sqrt(np.diagonal(runs, axis1=2, axis2=3).max(axis=0, initial=0.0))
    scale[scale == 0] = 1.0
    outer = scale[:, :, None] * scale[:, None, :]
    runs, known = runs / outer, known / outer
    base = known + RIDGE * np.eye(known.shape[-1])
    chosen: list[int] = []
    for _ in range(min(count, len(runs))):
        chosen.append(_best(runs, base + runs[chosen].sum(axis=0), chosen, targets, criterion))
    for _ in range(ROUNDS):
        before = list(chosen)
        for i in range(len(chosen)):
            rest = chosen[:i] + chosen[i + 1 :]
            best = _best(runs, base + runs[rest].sum(axis=0), rest, targets, criterion)
            chosen = [*chosen[:i], best, *chosen[i + 1 :]]
        if chosen == before:
            break
    return _in_order(runs, base, chosen, targets, criterion)


def _best(runs: np.ndarray, so_far: np.ndarray, taken: list[int], targets: Sequence[int], criterion: str) -> int:
    rest = np.setdiff1d(np.arange(len(runs)), taken)
    return int(rest[_least(so_far + runs[rest], targets, criterion)])


def _least(information: np.ndarray, targets: Sequence[int], criterion: str) -> int:
    """The smallest criterion; among near-equals the smallest determinant, then the first."""
    worth = spread(information, targets, criterion)
    tied = np.flatnonzero(worth <= worth.min() + TIE * (worth.min() if criterion == "c" else 1.0))
    volume = spread(information[tied], targets, "d")
    return int(tied[np.flatnonzero(volume <= volume.min() + TIE)[0]])


def _in_order(
    runs: np.ndarray, base: np.ndarray, chosen: list[int], targets: Sequence[int], criterion: str
) -> list[int]:
    """Order the runs by their own benefit."""
    left = list(chosen)
    order: list[int] = []
    while left:
        so_far = base + runs[order].sum(axis=0)
        order.append(left.pop(_least(so_far + runs[left], targets, criterion)))
    return order


# Median ratio of fitted run-error scales to their priors, for good tests.
TYPICAL = 0.7


def expected_std(
    runs: Sequence[Run], truth: Model, terms: TermTable, noise: Mapping[str, float], correlation_time: float,
    errors: RunErrors, made: Fit | None = None,
) -> dict[str, float]:  # fmt: skip
    """Standard error of each coefficient after some runs, with earlier tests."""
    tests = twin(truth, tuple(runs), {}, rate=RATE)
    equations, _ = accumulate(tests, terms)
    if made is not None:
        equations = _joined(made.normal_equations, equations)
    motions, problem = distinct_motions(equations), reduced(equations, terms)
    std: dict[str, float] = {}
    for own in joint_forces(problem):
        within = np.array([noise[f] ** 2 * max(1.0, 2 * correlation_time * RATE) for f in own])
        rows = ForceRows(equations, motions, problem, own, within)
        model, _, unit = assemble(rows, errors, truth.configuration)
        spread = model.at(np.full(len(model.prior), np.log(TYPICAL))).covariance
        size = np.sqrt(np.diag(spread)[: len(unit)]) * unit
        std |= {term.name: float(size[rows.free_parameters.index(problem.slot[term.name])]) for _, term in rows.terms}
    return std


def _joined(made: NormalEquations, planned: NormalEquations) -> NormalEquations:
    """Sums of the information of earlier and of planned tests."""
    names = set(planned.moved) & set(made.moved)
    return NormalEquations(
        planned.columns,
        np.concatenate([made.unweighted, planned.sums]),
        (*made.tests, *(f"planned {name}" for name in planned.tests)),
        {name: np.concatenate([made.moved[name], planned.moved[name]]) for name in names},
        planned.length,
    )
