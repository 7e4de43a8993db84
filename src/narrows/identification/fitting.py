"""Tests in, a fit out: ``identify`` of one condition, ``identify_conditions`` of each."""

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, Literal, get_args

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, check_choice, did_you_mean, shown
from narrows.captive.accelerations import CHOICES, Accelerations, with_accelerations
from narrows.captive.measured import measured_files
from narrows.captive.read import Tests, as_tests, read_captive
from narrows.captive.tests import CaptiveTests
from narrows.identification.fit import Fit
from narrows.identification.least_squares import bounded_problem
from narrows.identification.motions import distinct_motions, numbered
from narrows.identification.normal_equations import Balance, Score, accumulate, score
from narrows.identification.systematic_effects import RunErrors
from narrows.identification.verdict import unmodelled_rudder
from narrows.model.additions import pooled
from narrows.model.froude import scale_model
from narrows.model.model import Model
from narrows.model.tables import PAPER, STEERED, table_named
from narrows.model.term import TermTable
from narrows.ship.ship_file import ShipSource

Pool = Literal["depth"]
# Stretches of each test: their scatter about a fit to it gives the noise.
PIECES = 8
DEFAULT_ERRORS = RunErrors()
# A ship at full size from the tests that come with the package, for demonstrations.
ROWS = "type in ('PMMY2', 'PMMPSI2', 'STATX0', 'MULTI0') and u_mps > 0.2 and abs(psi_deg) < 20"
# 50 % under the keel; of the water [kg/m3].
CONDITION, DENSITY = "C0101A02", 1025.0


@accept_aliases
def identify(
    tests: Any, terms: TermTable | str = PAPER, balance: Balance = "tests",
    accelerations: Accelerations = "checked", errors: RunErrors = DEFAULT_ERRORS, pass_over: Sequence[str] = (),
    pool: Pool | None = None, ship: ShipSource | None = None,
) -> Fit:  # fmt: skip
    """Fit a table of terms to captive tests: the paper's joint constrained problem, solved exactly.

    Raises an InputError where an option is unknown, a table has no ship, the tests are of several conditions, or a
    rudder moves that no term has.

    Parameters
    ----------
    tests : CaptiveTests, StreamedTests, str, Path, DataFrame or Dataset
        Tests of one condition; a path is read as by ``read_captive``, for the ship of ``ship``.
    terms : TermTable or str
        The terms, their bounds and ties, or the name of a table that comes with the package.
    balance : str
        ``tests``: each test counts alike, a static run of one averaged row as much as a harmonic one of thousands;
        ``rows``: each row does, as in the paper.
    accelerations : str
        ``checked``: where the measured ones stray from a periodic or straight motion with time, those of the motion are
        taken, and ``notes`` say so; ``motion``: wherever the motion gives them; ``measured``: never.
    errors : RunErrors
        By how much runs differ beyond the noise within them, where the tests hold no repeats that say so.
    pass_over : sequence of str
        Actuators that may move while no term has them: ``rudder``.
    pool : str, optional
        ``depth``: tests at several depths together, with hull coefficients of their own at each and the bank's shared;
        whether these change with depth is tested, and ``notes`` say so.
    ship : str, Path, Configuration or mapping, optional
        Ship of a table that was not read yet, as of ``read_captive``; tests that were read have theirs.

    Examples
    --------
    >>> fit = nw.identify(tests)
    >>> bool(fit["b_vdot"] > 0)
    True
    """
    check_choice("balance", balance, get_args(Balance))
    check_choice("accelerations", accelerations, CHOICES)
    tests = as_tests(tests, ship)
    terms = table_named(terms) if isinstance(terms, str) else terms
    if not isinstance(terms, TermTable):
        raise InputError(f"terms = {shown(terms)} is no table of terms; give one, or the name of one")
    if pool is not None:
        check_choice("pool", pool, get_args(Pool))
        terms = pooled(terms, depths_of(tests))
    if isinstance(tests, CaptiveTests) and len(set(tests.conditions)) > 1 and not terms.needs_depth:
        labels = ", ".join(dict.fromkeys(tests.conditions))
        raise InputError(
            f"the tests are of several conditions ({labels}), which no one model fits unless its terms need the "
            "depth; identify each of tests.by_condition()"
        )
    for name in (pass_over,) if isinstance(pass_over, str) else pass_over:
        check_choice("pass_over", name, ("rudder",))
    if not isinstance(errors, RunErrors):
        raise InputError(f"errors = {shown(errors)} are no errors of runs; give nw.RunErrors(gain=..., zero=...)")
    if isinstance(tests, CaptiveTests):
        tests = with_accelerations(tests, accelerations)
    equations, data_range = accumulate(tests, terms, PIECES, balance)
    rudder = unmodelled_rudder(tests, equations, terms)
    if rudder and "rudder" not in pass_over:
        raise InputError(f"{rudder}, or fit all the same (--pass-over rudder, in Python pass_over='rudder')")
    if len(equations.tests) < 2:
        raise InputError(f"one row of test {equations.tests[0]} is all there is; standard errors need two or more")
    problem = bounded_problem(equations, terms)
    motions = distinct_motions(equations)
    if len(motions) > 1:
        left_out = score(equations, motions.sums, terms, problem.fits(motions.without))
    else:
        left_out = {force: Score(float("nan"), float("nan")) for force, part in terms.forces.items() if part}
    return Fit(tests, equations, problem, left_out, data_range, errors)


def depths_of(tests: Tests) -> list[float]:
    """Return the depths of tests, those within 5 % of the first of them as one [m]."""
    by_test: dict[str, list[float]] = {}
    for block in tests.blocks(1):
        depth = np.broadcast_to(block.values.get("depth", np.nan), block.rows)
        for span in block.spans:
            by_test.setdefault(span.test, []).append(float(depth[span.start : span.stop].mean()))
    means = np.array([np.mean(values) for values in by_test.values()])
    if not np.isfinite(means).all():
        raise InputError("the tests have no water depth; give depths in the ship file or a column")
    group = numbered(means)
    return [float(means[group == number].mean()) for number in range(group.max() + 1)]


@accept_aliases
def identify_conditions(
    tests: Any, condition: str | None = None, ship: ShipSource | None = None, **options: Any
) -> dict[str, Fit]:
    """Fit each condition of a table by itself: fits by condition, without a label where they are pooled.

    Raises an InputError where there is no such condition, or a table has no ship.

    Parameters
    ----------
    tests : CaptiveTests, StreamedTests, str, Path, DataFrame or Dataset
        Tests of one or several conditions.
    condition : str, optional
        Take this one alone.
    ship, **options
        As in ``identify``.

    Examples
    --------
    >>> sorted(nw.identify_conditions(tests))
    ['C0101A01']
    """
    tests = as_tests(tests, ship)
    if options.get("pool") is not None and condition is None:
        return {"": identify(tests, **options)}
    parts = _by_condition(tests) if condition is None else {condition: the_condition(tests, condition)}
    return {label: identify(part, **options) for label, part in parts.items()}


def the_condition(tests: Tests, condition: str | None) -> Tests:
    parts = _by_condition(tests)
    known = [label for label in parts if label]
    if condition is None and len(parts) > 1:
        raise InputError(f"the table holds several conditions: choose one with --condition {known[0]}")
    if condition is not None and condition not in parts:
        hint = did_you_mean(condition, known) if known else "; it names none, select rows instead"
        raise InputError(f"the table has no condition {condition!r}{hint}")
    return next(iter(parts.values())) if condition is None else parts[condition]


def _by_condition(tests: Tests) -> Mapping[str, Tests]:
    return tests.by_condition() if isinstance(tests, CaptiveTests) else {"": tests}


@cache
def bundled_ship(length: float, width: float, depth: float | None = None, terms: TermTable = STEERED) -> Model:
    """Return the KCS as identified from the bundled tests, with its rudder, at another length [m]."""
    table, ship = measured_files("kcs")
    fit = identify_conditions(read_captive(table, ship, ROWS), terms=terms)[CONDITION]
    return scale_model(fit.model, length, DENSITY, width=width, depth=depth).model
