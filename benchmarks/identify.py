"""Constrained fit of three forces: ours beside NumPy + BVLS, a stacked lsq_linear and cvxpy, in one run.

    python benchmarks/identify.py [ROWS] [--small]

Peers start from regressor matrices already formed, so ours does too; the way from motions is a row of its own.
cvxpy takes minutes at a million rows: it runs on a tenth of them and says so.
"""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
from common import installed, median_seconds, show, sizes
from scipy.optimize import lsq_linear

import narrows as nw
from narrows.identification.least_squares import bounded_problem, solve
from narrows.identification.normal_equations import DesignMatrix, NormalEquations, accumulate, products


def formed(tests: nw.CaptiveTests) -> tuple[DesignMatrix, np.ndarray]:
    """Every column of the design, (m, rows)."""
    layout = DesignMatrix(nw.PAPER, effects=False)
    return layout, np.concatenate([layout.evaluate(block).copy() for block in tests.blocks()], axis=1)


def sums_of(layout: DesignMatrix, design: np.ndarray) -> NormalEquations:
    """Sums of products, the rows shared among the cores as the blocks of a table are."""
    with ThreadPoolExecutor() as pool:
        total = sum(pool.map(products, np.array_split(design, 8, axis=1)))
    return NormalEquations(layout.columns, np.asarray(total)[None], ("all",), {}, 1.0)


def ours(layout: DesignMatrix, design: np.ndarray) -> dict[str, float]:
    """Columns to coefficients."""
    return fitted(sums_of(layout, design))


def from_motions(tests: nw.CaptiveTests) -> dict[str, float]:
    """Motions to coefficients."""
    return fitted(accumulate(tests, nw.PAPER)[0])


def fitted(equations: NormalEquations) -> dict[str, float]:
    """Sums to coefficients."""
    problem = bounded_problem(equations, nw.PAPER)
    solution = solve(*problem.normal(equations.total), problem.lower, problem.upper)
    return dict(zip(nw.PAPER.names, problem.coefficients(solution.z), strict=True))


def stacked(layout: DesignMatrix, design: np.ndarray) -> tuple[list[np.ndarray], list[np.ndarray], np.ndarray]:
    """The three regressor matrices over the 16 parameters, the forces, and the lower bounds."""
    slots = bounded_problem(sums_of(layout, design), nw.PAPER).slot
    size, lower = max(slots.values()) + 1, np.full(max(slots.values()) + 1, -np.inf)
    matrices, forces = [], []
    for force, terms in nw.PAPER.forces.items():
        matrix = np.zeros((design.shape[1], size))
        for term in terms:
            matrix[:, slots[term.name]] = design[layout.columns[term.name]]
            lower[slots[term.name]] = max(lower[slots[term.name]], term.bound[0])
        matrices.append(matrix)
        forces.append(design[layout.columns[force]])
    return matrices, forces, lower


def gram_and_bvls(
    columns: list[np.ndarray], tall: list[np.ndarray], forces: list[np.ndarray], lower: np.ndarray
) -> None:
    """The plain way in NumPy: three Gram matrices, the Cholesky factor of their scaled sum, BVLS."""
    h, g = np.zeros((len(lower), len(lower))), np.zeros(len(lower))
    for index, matrix, force in zip(columns, tall, forces, strict=True):
        h[np.ix_(index, index)] += matrix.T @ matrix
        g[index] += matrix.T @ force
    live = np.diag(h) > 0
    scale = np.sqrt(np.diag(h)[live])
    factor = np.linalg.cholesky(h[np.ix_(live, live)] / np.outer(scale, scale)).T
    lsq_linear(factor, np.linalg.solve(factor.T, g[live] / scale), (lower[live], np.inf), method="bvls")


def with_cvxpy(matrices: list[np.ndarray], forces: list[np.ndarray], lower: np.ndarray) -> None:
    """The paper's problem as written, by a modelling language."""
    import cvxpy

    z = cvxpy.Variable(len(lower))
    error = sum(cvxpy.sum_squares(f - m @ z) for m, f in zip(matrices, forces, strict=True))
    bound = np.flatnonzero(np.isfinite(lower))
    cvxpy.Problem(cvxpy.Minimize(error / len(forces[0])), [z[bound] >= lower[bound]]).solve()


def main(rows: int) -> None:
    """Measure and print."""
    # Two speeds, so that linear and quadratic resistance are two columns for the Cholesky of the plain way.
    runs = tuple(
        nw.HarmonicRun(f"{kind}{speed}", kind, 0.5, 25.0, speed) for kind in ("yaw", "sway") for speed in (0.7, 1.0)
    )
    tests = nw.twin(runs=runs, rate=rows / (4 * 6 * 25.0))
    layout, design = formed(tests)
    matrices, forces, lower = stacked(layout, design)
    columns = [np.flatnonzero(np.any(matrix, axis=0)) for matrix in matrices]
    tall = [np.ascontiguousarray(matrix[:, index]) for matrix, index in zip(matrices, columns, strict=True)]
    table = [
        ("narrows, from columns", median_seconds(lambda: ours(layout, design)), ""),
        ("narrows, from motions", median_seconds(lambda: from_motions(tests)), "columns formed on the way"),
        ("NumPy Gram + BVLS", median_seconds(lambda: gram_and_bvls(columns, tall, forces, lower)), ""),
        ("lsq_linear, stacked", median_seconds(lambda: lsq(matrices, forces, lower), runs=1), ""),
    ]
    if installed("cvxpy"):
        part = [m[::10] for m in matrices], [f[::10] for f in forces]
        table.append(
            ("cvxpy", 10 * median_seconds(lambda: with_cvxpy(*part, lower), runs=1), "10 x a tenth of the rows")
        )
    show(f"constrained fit, {tests.rows:.2g} rows x 3 forces", table, "ms", 1e3)


def lsq(matrices: list[np.ndarray], forces: list[np.ndarray], lower: np.ndarray) -> np.ndarray:
    """All rows of all forces in one tall matrix."""
    return lsq_linear(np.vstack(matrices), np.concatenate(forces), (lower, np.inf), method="bvls").x


if __name__ == "__main__":
    main(sizes(__doc__, usual=1e6, small=1e4)[0])
