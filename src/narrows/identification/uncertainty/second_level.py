"""A few numbers per motion and force that stand for all their rows: least squares on them is that on the rows."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from narrows.identification.motions import DistinctMotions
from narrows.identification.regression.normal_equations import ONE, NormalEquations
from narrows.identification.regression.problem import Problem

DIRECTION = 1e-9
"""Of the largest eigenvalue of a motion's scaled products: under it a direction holds rounding."""
LEAST_NOISE = 1e-6
"""Of the force's root mean square: what stands for noise where the rows show none."""


@dataclass(frozen=True)
class SecondLevel:
    """``y = D theta + error``, in blocks of q rows, one for each motion and force; empty rows are zero.

    With [A 1]'[A 1] = S V L V' S over the rows of a motion, S scales to one, D = L^1/2 V' S and
    y = L^-1/2 V' S^-1 [A 1]'F: D'D = A'A and D'y = A'F, so that nothing is lost but the rows' own noise. Parameters
    and forces are scaled and weighed as in the ``Problem``.

    Parameters
    ----------
    d : array (blocks, q, p)
        Columns of the parameters.
    own : array (blocks, q, n)
        Columns of the coefficients, before ties make one parameter of two.
    one : array (blocks, q)
        Column of a constant force.
    y : array (blocks, q)
        Measured.
    motion, force : array (blocks,) of int
        Which block is whose; forces are numbered as in the terms.
    repeats : array (blocks,) [1]
        How many runs a motion was made in.
    noise : array (blocks,)
        Variance of each row from the noise within runs.
    form : array (blocks,)
        Variance of each row from a form error as large as the force.
    level : array (blocks,)
        Root mean square of the force in all tests.
    live : array (blocks, q) of bool
        Rows that are not empty.
    noise_known : array (forces,) of bool
        Whether the rows of a force say how large its noise is.
    """

    d: np.ndarray
    own: np.ndarray
    one: np.ndarray
    y: np.ndarray
    motion: np.ndarray
    force: np.ndarray
    repeats: np.ndarray
    noise: np.ndarray
    form: np.ndarray
    level: np.ndarray
    live: np.ndarray
    noise_known: np.ndarray

    @property
    def forces(self) -> int:
        """How many forces there are."""
        return len(self.noise_known)

    def less(self, theta: np.ndarray, held: np.ndarray) -> "SecondLevel":
        """Return it with some parameters held: what they explain taken from y, their columns emptied.

        Parameters
        ----------
        theta : array (p,)
            Values.
        held : array (p,) of bool
            Which.
        """
        free = np.where(held, 0.0, 1.0)
        return replace(self, d=self.d * free, y=self.y - self.d @ np.where(held, theta, 0.0))


def second_level(equations: NormalEquations, motions: DistinctMotions, problem: Problem) -> SecondLevel:
    """Bring sums of products to blocks of a few rows (ours).

    Parameters
    ----------
    equations : NormalEquations
        Of pieces of tests, which say how large the noise is.
    motions : DistinctMotions
        Which tests are one motion.
    problem : Problem
        Scale of the parameters, weights of the forces.
    """
    forces = [force for force, part in problem.terms.forces.items() if part]
    parts = [_of_force(equations, motions, problem, force) for force in forces]
    width = max(part["y"].shape[1] for part in parts)
    joined = {name: np.concatenate([_widened(part[name], width, name) for part in parts]) for name in parts[0]
              if name != "known"}  # fmt: skip
    numbers = np.repeat(np.arange(len(forces)), len(motions))
    known = np.array([part["known"] for part in parts])
    return SecondLevel(force=numbers, noise_known=known, **joined)


def _widened(array: np.ndarray, width: int, name: str) -> np.ndarray:
    if name not in ("d", "own", "one", "y", "live"):
        return array
    wide = np.zeros((len(array), width, *array.shape[2:]), array.dtype)
    wide[:, : array.shape[1]] = array
    return wide


def _of_force(
    equations: NormalEquations, motions: DistinctMotions, problem: Problem, force: str
) -> Mapping[str, np.ndarray]:
    """The blocks of one force."""
    terms = problem.terms
    names = [term.name for term in terms.forces[force]]
    columns = [*names, ONE, force]
    picked = equations.pick(motions.sums, columns) * problem.weights[force]
    root, inverse, live = roots(picked[:, :-1, :-1])
    y = np.einsum("mqk,mk->mq", inverse, picked[:, :-1, -1])
    p, n = len(problem.scale), len(terms.names)
    d, own = np.zeros((*y.shape, p)), np.zeros((*y.shape, n))
    for j, name in enumerate(names):
        column = root[:, :, j] / problem.scale[problem.slot[name]]
        d[:, :, problem.slot[name]] += column
        own[:, :, terms.names.index(name)] = column
    square = picked[:, -1, -1]
    noise, known = _noise(equations.pick(equations.sums, columns) * problem.weights[force], equations)
    level = np.sqrt(square.sum() / picked[:, -2, -2].sum() * problem.weights[force])
    count = len(motions)
    return {
        "d": d, "own": own, "one": root[:, :, -1], "y": y, "live": live,
        "motion": np.arange(count), "repeats": np.array([len(own) for own in motions.members], float),
        "noise": np.full(count, max(noise, (LEAST_NOISE * level) ** 2)),
        "form": square / np.maximum(live.sum(axis=1), 1),
        "level": np.full(count, level / np.sqrt(problem.weights[force])), "known": np.array(known),
    }  # fmt: skip


def roots(gram: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Factor stacks of products, H = R'R: R (m, k, k), its inverse from the left for H z = g, and which rows live.

    Parameters
    ----------
    gram : array (m, k, k)
        Sums of products of columns.
    """
    size = np.sqrt(np.maximum(np.diagonal(gram, axis1=1, axis2=2), 0.0))
    full, size = size > 0, np.where(size > 0, size, 1.0)
    values, vectors = np.linalg.eigh(gram / (size[:, :, None] * size[:, None, :]))
    live = values > DIRECTION * np.maximum(values[:, -1:], 1e-300)
    root = np.sqrt(np.where(live, values, 0.0))
    back = np.where(live, 1 / np.where(live, root, 1.0), 0.0)
    turned = np.swapaxes(vectors, 1, 2) * full[:, None, :]  # an empty column stays empty, rounding and all
    return root[:, :, None] * turned * size[:, None, :], back[:, :, None] * turned / size[:, None, :], live


def _noise(sums: np.ndarray, equations: NormalEquations) -> tuple[float, bool]:
    """Variance of a row's noise as it adds up over a run, from how fits to a run err on its stretches.

    Each run is fitted by itself. What its stretches leave, in the directions of its columns, adds up to 0; the noise is
    as large as their spread. Correlation within a stretch is in it, since what a stretch leaves is a sum over it.
    """
    names = equations.names
    place = np.array([names.index(test) for test in equations.tests])
    whole = np.zeros((len(names), *sums.shape[1:]))
    np.add.at(whole, place, sums)
    _, inverse, live = roots(whole[:, :-1, :-1])
    seen = (inverse @ whole[:, :-1, -1:])[..., 0]
    fit = (seen[:, None] @ inverse)[:, 0][place]
    left = sums[:, :-1, -1] - (sums[:, :-1, :-1] @ fit[..., None])[..., 0]
    back = inverse[place]
    score = (back @ left[..., None])[..., 0]
    share = back @ sums[:, :-1, :-1] @ np.swapaxes(back, 1, 2)
    freedom = live.sum() - (share**2).sum()
    rows = whole[:, -2, -2].sum() - live.sum()
    rest = (seen**2).sum()
    plain = max(float(whole[:, -1, -1].sum() - rest), 0.0) / max(rows, 1.0)
    if rows < 1:
        return 0.0, False
    return (max(plain, float((score**2).sum() / freedom)) if freedom > 1 else plain), True
