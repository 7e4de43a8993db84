"""A few numbers per motion and force that stand for all their rows: least squares on them is that on the rows."""

from dataclasses import dataclass, replace

import numpy as np

from narrows.identification.motions import DistinctMotions
from narrows.identification.regression.normal_equations import ONE, NormalEquations
from narrows.identification.regression.problem import Problem

# Of the largest eigenvalue of a motion's scaled products: under it a direction holds rounding.
DIRECTION = 1e-9
# Of the force's root mean square: what stands for noise where the rows show none.
LEAST_NOISE = 1e-6


@dataclass(frozen=True)
class SecondLevel:
    """``y = D theta + error``, in blocks of q rows, one for each motion and force; empty rows are zero."""

    # With [A 1]'[A 1] = S V L V' S over the rows of a motion, S scales to one, D = L^1/2 V' S and y = L^-1/2 V' S^-1
    # [A 1]'F: D'D = A'A and D'y = A'F, so that nothing is lost but the rows' own noise. Parameters and forces are
    # scaled and weighed as in the ``Problem``.

    d: np.ndarray  # (blocks, q, p) Columns of the parameters
    columns: np.ndarray  # (blocks, q, n) Columns of the coefficients, before ties make one parameter of two
    one: np.ndarray  # (blocks, q) Column of a constant force
    y: np.ndarray  # (blocks, q) Measured
    motion: np.ndarray  # (blocks,) Which block is whose; forces are numbered as in the terms
    force: np.ndarray  # (blocks,) Which block is whose; forces are numbered as in the terms
    repeats: np.ndarray  # (blocks,) How many runs a motion was made in [1]
    noise: np.ndarray  # (blocks,) Variance of each row from the noise within runs
    form: np.ndarray  # (blocks,) Variance of each row from a form error as large as the force
    level: np.ndarray  # (blocks,) Root mean square of the force in all tests
    live: np.ndarray  # (blocks, q) Rows that are not empty
    noise_known: np.ndarray  # (forces,) Whether the rows of a force say how large its noise is

    @property
    def forces(self) -> int:
        """How many forces there are."""
        return len(self.noise_known)

    def less(self, theta: np.ndarray, held: np.ndarray) -> "SecondLevel":
        """Return it with some parameters held: what they explain taken from y, their columns emptied."""
        # theta (p,); held (p,)
        free = np.where(held, 0.0, 1.0)
        return replace(self, d=self.d * free, y=self.y - self.d @ np.where(held, theta, 0.0))


def second_level(equations: NormalEquations, motions: DistinctMotions, problem: Problem) -> SecondLevel:
    """Bring sums of products to blocks of a few rows."""
    count, forces = len(motions), _fitted_forces(problem)
    rows = _rows(motions.sums, problem)
    errors = [_errors(equations, motions.sums, problem, force) for force in forces]
    noise, square, level, known = (np.array(part) for part in zip(*errors, strict=True))
    repeats = np.array([len(tests) for tests in motions.members], float)
    noisy = np.array([equations.noise_weight(tests) for tests in motions.members])
    return SecondLevel(
        **rows,
        motion=np.tile(np.arange(count), len(forces)),
        force=np.repeat(np.arange(len(forces)), count),
        repeats=np.tile(repeats, len(forces)),
        noise=np.outer(noise, noisy).ravel(),
        form=square.ravel() / np.maximum(rows["live"].sum(axis=1), 1),
        level=np.repeat(level, count),
        noise_known=known,
    )


def in_halves(level: SecondLevel, motions: DistinctMotions, problem: Problem) -> SecondLevel:
    """Return the same with rows for the first half of each run and, behind them, rows for the later half."""
    first, later = (_rows(sums, problem) for sums in motions.halves)
    return replace(level, **{name: np.concatenate([first[name], later[name]], axis=1) for name in first})


def _fitted_forces(problem: Problem) -> list[str]:
    return [force for force, part in problem.terms.forces.items() if part]


def _rows(sums: np.ndarray, problem: Problem) -> dict[str, np.ndarray]:
    """What has a row for each direction, of all forces: ``d``, ``columns``, ``one``, ``y`` and ``live``."""
    parts = [_rows_of_force(sums, problem, force) for force in _fitted_forces(problem)]
    width = max(part["y"].shape[1] for part in parts)
    return {name: np.concatenate([_widened(part[name], width) for part in parts]) for name in parts[0]}


def _widened(array: np.ndarray, width: int) -> np.ndarray:
    wide = np.zeros((len(array), width, *array.shape[2:]), array.dtype)
    wide[:, : array.shape[1]] = array
    return wide


def _picked(sums: np.ndarray, problem: Problem, force: str) -> np.ndarray:
    """Products of a force's columns, of a constant and of the force."""
    names = [term.name for term in problem.terms.forces[force]]
    index = np.array([problem.columns[name] for name in (*names, ONE, force)])
    return np.asarray(sums[..., index[:, None], index] * problem.weights[force])


def _rows_of_force(sums: np.ndarray, problem: Problem, force: str) -> dict[str, np.ndarray]:
    terms, products = problem.terms, _picked(sums, problem, force)
    root, inverse, live = roots(products[:, :-1, :-1])
    y = np.einsum("mqk,mk->mq", inverse, products[:, :-1, -1])
    d, columns = np.zeros((*y.shape, len(problem.scale))), np.zeros((*y.shape, len(terms.names)))
    for j, term in enumerate(terms.forces[force]):
        slot = problem.slot[term.name]
        column = root[:, :, j] / problem.scale[slot]
        d[:, :, slot] += column
        columns[:, :, terms.names.index(term.name)] = column
    return {"d": d, "columns": columns, "one": root[:, :, -1], "y": y, "live": live}


def _errors(
    equations: NormalEquations, sums: np.ndarray, problem: Problem, force: str
) -> tuple[float, np.ndarray, float, bool]:
    """Noise of a force, the square of each motion's, the root mean square in all tests; whether the noise is known."""
    products = _picked(sums, problem, force)
    square = products[:, -1, -1]
    noise, known = _noise(_picked(equations.unweighted, problem, force), equations)
    level = np.sqrt(square.sum() / products[:, -2, -2].sum() * problem.weights[force])
    return max(noise, (LEAST_NOISE * level) ** 2), square, level / np.sqrt(problem.weights[force]), known


def roots(gram: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Factor stacks of products, H = R'R: R (m, k, k), its inverse from the left for H z = g, and which rows live."""
    # gram (m, k, k)
    size = np.sqrt(np.maximum(np.diagonal(gram, axis1=1, axis2=2), 0.0))
    full, size = size > 0, np.where(size > 0, size, 1.0)
    values, vectors = np.linalg.eigh(gram / (size[:, :, None] * size[:, None, :]))
    live = values > DIRECTION * np.maximum(values[:, -1:], 1e-300)
    root = np.sqrt(np.where(live, values, 0.0))
    back = np.where(live, 1 / np.where(live, root, 1.0), 0.0)
    turned = np.swapaxes(vectors, 1, 2) * full[:, None, :]  # an empty column stays empty, rounding and all
    return root[:, :, None] * turned * size[:, None, :], back[:, :, None] * turned / size[:, None, :], live


def _noise(sums: np.ndarray, equations: NormalEquations) -> tuple[float, bool]:
    """Variance of a row's noise as it adds up over a run, from how fits to a run err on its stretches."""
    # Each run is fitted by itself. What its stretches leave, in the directions of its columns, adds up to 0; the noise
    # is as large as their spread. Correlation within a stretch is in it, since what a stretch leaves is a sum over it.
    names = equations.names
    test = np.array([names.index(name) for name in equations.tests])
    whole = np.zeros((len(names), *sums.shape[1:]))
    np.add.at(whole, test, sums)
    _, inverse, live = roots(whole[:, :-1, :-1])
    seen = (inverse @ whole[:, :-1, -1:])[..., 0]
    fit = (seen[:, None] @ inverse)[:, 0][test]
    left = sums[:, :-1, -1] - (sums[:, :-1, :-1] @ fit[..., None])[..., 0]
    back = inverse[test]
    score = (back @ left[..., None])[..., 0]
    share = back @ sums[:, :-1, :-1] @ np.swapaxes(back, 1, 2)
    freedom = live.sum() - (share**2).sum()
    rows = whole[:, -2, -2].sum() - live.sum()
    rest = (seen**2).sum()
    plain = max(float(whole[:, -1, -1].sum() - rest), 0.0) / max(rows, 1.0)
    if rows < 1:
        return 0.0, False
    return (max(plain, float((score**2).sum() / freedom)) if freedom > 1 else plain), True
