"""Sums of products against NumPy on the rows, over all of them, over each test and over each stretch."""

import numpy as np
import pytest

import narrows as nw
from narrows.identification.motions import distinct_motions
from narrows.identification.normal_equations import ONE, accumulate, products
from narrows.identification.verdict import diagnose
from tables import many_runs, short_twin


def rows_of(tests: nw.CaptiveTests, own: dict[str, np.ndarray] | None = None) -> dict[str, np.ndarray]:
    """Every coefficient's column, every force and the constant, from the rows of all tests or of one."""
    columns = own or tests.columns
    values = {**tests.configuration.values(), **columns}
    rows = len(columns["u"])
    return (
        {term.name: np.broadcast_to(term.column(values), rows) for term in nw.PAPER.terms}
        | {force: columns[force] for force in "XYN"}
        | {ONE: np.ones(rows)}
    )


def rows_behind(equations, sums: np.ndarray) -> float:
    return round(float(equations.pick(sums, [ONE])[0, 0]), 6)


def assert_products(equations, sums: np.ndarray, rows: dict[str, np.ndarray]) -> None:
    names = list(rows)
    matrix = np.column_stack(list(rows.values()))
    size = np.sqrt(np.diag(matrix.T @ matrix))
    size[size == 0] = 1.0
    scale = np.outer(size, size)
    np.testing.assert_allclose(equations.pick(sums, names) / scale, matrix.T @ matrix / scale, atol=1e-12)


def test_over_all_rows_and_over_each_test(short: nw.CaptiveTests) -> None:
    equations, _ = accumulate(short, nw.PAPER, pieces=5)
    assert_products(equations, equations.total, rows_of(short))
    assert rows_behind(equations, equations.total) == short.rows
    assert equations.names == short.names
    for name, sums in zip(short.names, equations.by_test(equations.sums), strict=True):
        assert_products(equations, sums, rows_of(short, short.test(name)))


def test_over_each_stretch(short: nw.CaptiveTests) -> None:
    """About equal consecutive stretches, each row in one."""
    equations, _ = accumulate(short, nw.PAPER, pieces=3)
    assert equations.tests == tuple(name for name in short.names for _ in range(3))
    for i, name in enumerate(short.names):
        own = short.test(name)
        edges = [len(own["u"]) * k // 3 for k in range(4)]
        for piece in range(3):
            part = {key: column[edges[piece] : edges[piece + 1]] for key, column in own.items()}
            assert_products(equations, equations.sums[3 * i + piece], rows_of(short, part))
            for quantity in ("u", "y", "sin_psi", "vdot"):
                moments = len(part[quantity]), part[quantity].sum(), (part[quantity] ** 2).sum()
                np.testing.assert_allclose(equations.moved[quantity][3 * i + piece], moments, rtol=1e-11, atol=1e-11)


def test_a_test_with_fewer_rows_than_stretches_leaves_none_empty() -> None:
    tests = nw.twin(runs=(nw.HarmonicRun("A", "yaw", 0.3, 12.0, 1.0, 1),), rate=0.25)
    equations, _ = accumulate(tests, nw.PAPER, pieces=30)
    assert [rows_behind(equations, sums) for sums in equations.sums] == [1] * tests.rows


def test_coefficients_of_one_regressor_share_a_column(short: nw.CaptiveTests) -> None:
    columns = accumulate(short, nw.PAPER)[0].columns
    for name in ("vdot", "rdot", "v", "r", "vv", "rr"):
        assert columns[f"b_{name}"] == columns[f"c_{name}"]
    assert columns["b_bank"] != columns["c_bank"]
    named = [*nw.PAPER.names, *"XYN", "1"]
    assert len({columns[name] for name in named}) == 3 + 8 + 3 + 1


@pytest.mark.parametrize("columns", [1, 4, 15, 16, 23])
@pytest.mark.parametrize("rows", [1, 2047, 2048, 2049, 96_007])
def test_products_of_any_size(rows: int, columns: int) -> None:
    """Short ones in one go, long ones in strips."""
    design = np.random.default_rng(rows).standard_normal((columns, rows))
    found = products(design)
    np.testing.assert_allclose(found, design @ design.T, rtol=1e-11, atol=1e-10)
    np.testing.assert_array_equal(found, products(design))


def test_ranges_that_the_rows_cover(short: nw.CaptiveTests) -> None:
    envelope = accumulate(short, nw.PAPER)[1]
    for name, column in (("speed", "u"), ("abs_y", "y"), ("abs_psi", "psi"), ("abs_r", "r")):
        values = short.columns[column] if name == "speed" else np.abs(short.columns[column])
        assert getattr(envelope, name) == (values.min(), values.max())
    assert envelope.depth_to_draft is None


def test_sums_without_a_motion_are_those_of_the_others() -> None:
    """Added up and not taken away: where no other test excites a column its sums are zero and not rounding."""
    runs = (*many_runs(10)[::2], nw.HarmonicRun("last", "sway", 0.8, 25.0, 1.0, 1))
    kept = short_twin(0, runs)
    equations, _ = accumulate(kept, nw.PAPER, 7)
    motions = distinct_motions(equations)
    for i, _ in enumerate(motions.labels):
        others = np.delete(motions.sums, i, axis=0).sum(axis=0)
        np.testing.assert_allclose(motions.without[i], others, rtol=1e-12, atol=1e-9)
    last = motions.labels.index("last")
    assert diagnose(equations, motions.without[last], nw.PAPER.sway).empty == ("b_vdot", "b_v", "b_vv")
