"""The solver against SciPy's stacked BVLS, against every active set by brute force, and against its own conditions."""

from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import lsq_linear

import narrows as nw
from narrows.identification import least_squares
from narrows.identification.least_squares import Problem, bounded_problem, kkt_residuals, solve, solve_many
from narrows.identification.normal_equations import accumulate


def stacked(tests: nw.CaptiveTests, terms: nw.TermTable = nw.PAPER) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Every row of every force in one matrix over the parameters, without our sums; forces; lower bounds."""
    slots = {name: i for i, name in enumerate(n for n in terms.names if n != "c_vdot")}
    slots["c_vdot"] = slots["b_rdot"]
    values = {**tests.configuration.values(), **tests.columns}
    rows, right = [], []
    for force, own in terms.forces.items():
        matrix = np.zeros((tests.rows, len(slots) - 1))
        for term in own:
            matrix[:, slots[term.name]] = term.column(values)
        rows.append(matrix)
        right.append(tests.columns[force])
    lower = np.full(len(slots) - 1, -np.inf)
    for term in terms.terms:
        lower[slots[term.name]] = max(lower[slots[term.name]], term.bound[0])
    return np.vstack(rows), np.concatenate(right), lower


@pytest.mark.parametrize("clearance", [100, 50, 20])
def test_kcs_agrees_with_stacked_bvls(kcs_tests: dict[int, nw.CaptiveTests], clearance: int) -> None:
    """To 1e-8 relative, on the very rows."""
    tests = kcs_tests[clearance]
    matrix, right, lower = stacked(tests)
    live = np.any(matrix, axis=0)
    scale = np.linalg.norm(matrix[:, live], axis=0)
    found = lsq_linear(matrix[:, live] / scale, right, (lower[live] * scale, np.inf), method="bvls", tol=1e-15)
    names = [name for name in nw.PAPER.names if name != "c_vdot"]
    expected = dict(zip(np.array(names)[live], found.x / scale, strict=True))
    fit = nw.identify(tests)
    for name, value in expected.items():
        assert fit.least_squares[name] == pytest.approx(value, rel=1e-8, abs=1e-10 / scale.max())
    assert fit.least_squares["c_vdot"] == fit.least_squares["b_rdot"]
    assert fit.solution.kkt.satisfied


def brute_force(h: np.ndarray, g: np.ndarray, lower: np.ndarray) -> np.ndarray:
    """The best of all choices of parameters held at their bound."""
    best, worth = np.zeros(len(g)), np.inf
    for held in product([False, True], repeat=len(g)):
        z = np.where(held, lower, 0.0)
        free = ~np.array(held)
        if not np.isfinite(z).all():
            continue
        z[free] = np.linalg.solve(h[np.ix_(free, free)], g[free] - h[np.ix_(free, ~free)] @ z[~free])
        value = 0.5 * z @ h @ z - g @ z
        if (z >= lower - 1e-12).all() and value < worth:
            best, worth = z, value
    return best


@pytest.mark.parametrize("seed", range(25))
def test_solver_agrees_with_every_active_set(seed: int) -> None:
    draw = np.random.default_rng(seed)
    matrix = draw.normal(size=(20, 6)) @ draw.normal(size=(6, 6))
    matrix /= np.linalg.norm(matrix, axis=0)
    h, g = matrix.T @ matrix, matrix.T @ draw.normal(size=20)
    lower = np.where(draw.random(6) < 0.7, 0.0, -np.inf)
    solution = solve(h, g, lower, np.full(6, np.inf))
    np.testing.assert_allclose(solution.z, brute_force(h, g, lower), rtol=1e-7, atol=1e-9)
    assert solution.kkt.satisfied


def test_a_stack_of_problems_is_solved_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """As one by one, with bounds on both sides, and without falling back on that."""
    random = np.random.default_rng(4)
    roots = random.standard_normal((200, 5, 5))
    h, g = roots @ roots.swapaxes(1, 2) + 0.5 * np.eye(5), 3.0 * random.standard_normal((200, 5))
    lower, upper = np.full(5, -0.4), np.array([0.3, 0.5, np.inf, 0.2, 0.4])
    each = np.array([solve(one, other, lower, upper).z for one, other in zip(h, g, strict=True)])
    assert (each == lower).any()
    assert (each == upper).any()
    fallen_back: list[int] = []
    monkeypatch.setattr(least_squares, "solve", lambda *given: fallen_back.append(1) or solve(*given))
    np.testing.assert_allclose(solve_many(h, g, lower, upper), each, atol=1e-9)
    assert len(fallen_back) < 10  # the primal-dual method may cycle


def test_conditions_fail_at_a_wrong_point() -> None:
    h, g, lower, upper = np.eye(2), np.array([1.0, -1.0]), np.zeros(2), np.full(2, np.inf)
    assert kkt_residuals(h, g, np.array([1.0, 0.0]), lower, upper).satisfied
    assert kkt_residuals(h, g, np.array([0.5, 0.0]), lower, upper).stationarity == pytest.approx(0.5)
    assert kkt_residuals(h, g, np.array([0.0, 0.0]), lower, upper).multiplier == pytest.approx(1.0)
    assert kkt_residuals(h, g, np.array([1.0, -0.1]), lower, upper).infeasibility == pytest.approx(0.1)


@pytest.mark.parametrize("size", [1.0, 100.0])
def test_a_direction_counts_as_data_from_a_millionth_of_the_largest_singular_value(size: float) -> None:
    """Eigenvalues of H are squares of singular values: 1e-12 of the largest is the limit."""
    free = np.full(2, -np.inf), np.full(2, np.inf)
    g = size * np.array([1.0, 2e-11])
    np.testing.assert_allclose(solve(size * np.diag([1.0, 1e-11]), g, *free).z, [1.0, 2.0], rtol=1e-9)
    np.testing.assert_allclose(solve(size * np.diag([1.0, 1e-13]), g, *free).z, [1.0, 0.0], rtol=1e-9)


def test_conditions_at_both_bounds_are_relative_to_the_largest_force() -> None:
    """Gradient z - g, by hand: at the upper bound 1, the lower -1, outside, and between equal bounds."""
    h, lower, upper = np.eye(2), np.array([-1.0, -1.0]), np.array([1.0, 1.0])

    def residuals(g: list[float], z: list[float], upper: np.ndarray = upper) -> tuple[float, ...]:
        return tuple(kkt_residuals(h, np.array(g), np.array(z), lower, upper))

    assert residuals([10.0, -10.0], [1.0, -1.0]) == (0.0, 0.0, 0.0)
    assert residuals([-10.0, 5.0], [1.0, -1.0]) == pytest.approx((0.0, 1.1, 0.0))
    assert residuals([-2.0, 10.0], [1.0, -1.0]) == pytest.approx((0.0, 1.1, 0.0))
    assert residuals([10.0, 2.0], [1.0, 0.5]) == pytest.approx((0.15, 0.0, 0.0))
    assert residuals([0.1, 0.0], [0.05, 0.0]) == pytest.approx((0.5, 0.0, 0.0))
    assert residuals([10.0, -10.0], [1.5, -1.2]) == pytest.approx((0.0, 0.0, 0.5))
    assert residuals([10.0, 0.0], [1.0, -1.0], np.array([1.0, -1.0])) == (0.0, 0.0, 0.0)
    assert solve(h, np.array([10.0, 0.5]), lower, upper).at_bound.tolist() == [True, False]
    assert solve(h, np.array([-10.0, 0.5]), lower, upper).at_bound.tolist() == [True, False]


def test_sums_of_products_make_the_problem_of_all_rows() -> None:
    """Coefficients p, q, s of Y and t, w of N; q shares a parameter with p, and t with s: one dense matrix."""
    rng = np.random.default_rng(2)
    names = ["p", "q", "s", "t", "w", "Y", "N"]
    rows = rng.standard_normal((2, 9, 7))
    forces = {"X": (), **{f: [SimpleNamespace(name=n) for n in own] for f, own in (("Y", "pqs"), ("N", "tw"))}}
    table, slot = SimpleNamespace(forces=forces, names=tuple("pqstw")), {"p": 0, "q": 0, "s": 1, "t": 1, "w": 2}
    scale, bounds = np.array([2.0, 0.5, 4.0]), np.array([[-1.0, 3.0], [0.0, np.inf], [-np.inf, 2.0]])
    problem = Problem(slot, scale, bounds, table, {name: i for i, name in enumerate(names)})  # type: ignore[arg-type]
    h, g = problem.normal(np.einsum("nri,nrj->nij", rows, rows))
    for k in range(2):
        p, q, s, t, w, y, n = rows[k].T
        dense = np.vstack([np.stack([p + q, s, 0 * w], axis=1), np.stack([0 * p, t, w], axis=1)]) / scale
        np.testing.assert_allclose(h[k], dense.T @ dense, atol=1e-12)
        np.testing.assert_allclose(g[k], dense.T @ np.concatenate([y, n]), atol=1e-12)
    assert problem.lower.tolist() == [-2.0, 0.0, -np.inf]
    assert problem.upper.tolist() == [6.0, np.inf, 8.0]
    assert problem.named(np.array([2.0, 3.0, 8.0])) == {"p": 1.0, "q": 1.0, "s": 6.0, "t": 6.0, "w": 2.0}
    each = np.array([solve(*one, problem.lower, problem.upper).z for one in zip(h, g, strict=True)])
    np.testing.assert_allclose(
        problem.fits(np.einsum("nri,nrj->nij", rows, rows)), (each / scale)[:, [0, 0, 1, 1, 2]], rtol=1e-9, atol=1e-12
    )


def test_a_direction_without_data_stays_at_its_smallest_norm() -> None:
    matrix = np.array([[1.0, 1.0], [2.0, 2.0]]) / np.sqrt(5)
    h, g = matrix.T @ matrix, matrix.T @ np.array([1.0, 2.0])
    z = solve(h, g, np.full(2, -np.inf), np.full(2, np.inf)).z
    np.testing.assert_allclose(z, [np.sqrt(5) / 2] * 2)


def test_sums_are_those_of_the_rows(short: nw.CaptiveTests) -> None:
    equations, envelope = accumulate(short, nw.PAPER)
    matrix, right, _ = stacked(short)
    h, g = bounded_problem(equations, nw.PAPER).normal(equations.total)
    scale = bounded_problem(equations, nw.PAPER).scale
    order = [bounded_problem(equations, nw.PAPER).slot[name] for name in nw.PAPER.names if name != "c_vdot"]
    np.testing.assert_allclose(
        (h * np.outer(scale, scale))[np.ix_(order, order)], matrix.T @ matrix, rtol=1e-10, atol=1e-9
    )
    np.testing.assert_allclose((g * scale)[order], matrix.T @ right, rtol=1e-9, atol=1e-7)
    assert envelope.abs_y == (pytest.approx(0.0, abs=0.05), pytest.approx(np.abs(short.columns["y"]).max()))


def test_left_out_scores_are_those_of_explicit_refits() -> None:
    from tables import many_runs

    tests = nw.twin(runs=many_runs(), rate=4.0, seed=1)
    fit = nw.identify(tests, balance="rows")
    assert len(fit.motions) > 1
    error, truth = 0.0, nw.published("mikkelsen2025_dtc")
    assert truth.configuration == tests.configuration
    for i, _ in enumerate(tests.names):
        kept = [j != i for j in range(len(tests.names))]
        refit = nw.identify(tests.where(kept), balance="rows")
        out = tests.where([not k for k in kept])
        model = truth.with_coefficients(**refit.least_squares)
        error += ((out.columns["Y"] - model.forces(motion_of(out))["Y"]) ** 2).sum()
    spread = ((tests.columns["Y"] - tests.columns["Y"].mean()) ** 2).sum()
    assert fit.left_out["Y"].r2 == pytest.approx(1 - error / spread, rel=1e-9)


def motion_of(tests: nw.CaptiveTests) -> nw.Motion:
    return nw.Motion(**{n: c for n, c in tests.columns.items() if n in nw.Motion().values()})


def test_scores_from_sums_are_those_from_rows(short: nw.CaptiveTests) -> None:
    fit = nw.identify(short, balance="rows")
    estimated = fit.model.forces(motion_of(short))
    for force, own in fit.scores.items():
        residual = short.columns[force] - estimated[force]
        assert own.rmse == pytest.approx(np.sqrt(np.mean(residual**2)), rel=1e-9)
        assert own.r2 == pytest.approx(1 - residual.var() / short.columns[force].var(), abs=0.02)


def test_each_test_counts_alike_however_many_rows_it_has(short: nw.CaptiveTests) -> None:
    """Rows of the first test written ten times over change nothing; as rows they do."""
    again = np.concatenate([np.repeat(np.arange(short.starts[1]), 10), np.arange(short.starts[1], short.rows)])
    longer = nw.CaptiveTests(
        {name: column[again] for name, column in short.columns.items()}, short.names,
        np.concatenate([[0], short.starts[1:] + 9 * short.starts[1]]), short.configuration,
    )  # fmt: skip
    alike, plain = nw.identify(longer), nw.identify(longer, balance="rows")
    for name, value in nw.identify(short).least_squares.items():
        assert alike.least_squares[name] == pytest.approx(value, rel=1e-9, abs=1e-12)
    assert plain.least_squares["b_v"] != pytest.approx(alike.least_squares["b_v"], rel=1e-3)


def test_a_test_counts_by_explicit_weights(short: nw.CaptiveTests) -> None:
    """One over its number of rows, on every row: SciPy's bounded least squares."""
    matrix, right, lower = stacked(short)
    rows = np.diff(short.starts)
    weight = np.tile(np.sqrt(np.repeat(1 / rows, rows)), 3)
    live = np.any(matrix, axis=0)
    scaled = matrix[:, live] * weight[:, None]
    norm = np.linalg.norm(scaled, axis=0)
    found = lsq_linear(scaled / norm, right * weight, (lower[live] * norm, np.inf), method="bvls", tol=1e-15).x / norm
    names = np.array([name for name in nw.PAPER.names if name != "c_vdot"])[live]
    fit = nw.identify(short)
    for name, value in zip(names, found, strict=True):
        assert fit.least_squares[name] == pytest.approx(value, rel=1e-6, abs=1e-8)
