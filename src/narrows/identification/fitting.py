"""Tests in, fits out: of one condition, of each, of several tables of terms, beside a model; the bundled ship."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, check_choice, did_you_mean, shown
from narrows.base.named_values import Named
from narrows.base.results import BaseResult
from narrows.captive.accelerations import CHOICES, Accelerations, with_accelerations
from narrows.captive.measured import measured_files
from narrows.captive.read import Tests, as_tests, read_captive
from narrows.captive.tests import CaptiveTests
from narrows.identification.fit import Fit
from narrows.identification.least_squares import bounded_problem
from narrows.identification.motions import grouped
from narrows.identification.normal_equations import Balance, Score, Scored, accumulate, score
from narrows.identification.systematic_effects import RunErrors
from narrows.identification.verdict import NOT_SEPARABLE, unmodelled_rudder
from narrows.model.additions import pooled
from narrows.model.data_range import extrapolation
from narrows.model.derived_models import scale_model
from narrows.model.model import Model
from narrows.model.tables import BARE, FORMS, OPEN_WATER, PAPER, STEERED, table_named
from narrows.model.term import TermTable
from narrows.quantities.names import FORCES
from narrows.ship.ship_file import ShipSource

if TYPE_CHECKING:
    import pandas as pd

Pool = Literal["depth"]
# Stretches of each test: their scatter about a fit to it gives the noise.
PIECES = 8
DEFAULT_ERRORS = RunErrors()
# Tests of the ship for demonstrations, which has 50 % of its draft under the keel.
ROWS = "type in ('PMMY2', 'PMMPSI2', 'STATX0', 'MULTI0') and u_mps > 0.2 and abs(psi_deg) < 20"


@accept_aliases
def identify(
    tests: Any, terms: TermTable | str = PAPER, balance: Balance = "tests",
    accelerations: Accelerations = "checked", errors: RunErrors = DEFAULT_ERRORS, pass_over: Sequence[str] = (),
    pool: Pool | None = None, ship: ShipSource | None = None, fixed: Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
) -> Fit:  # fmt: skip
    """Fit a table of terms to captive tests: the paper's joint constrained problem, solved exactly.

    Raises an InputError for an unknown option, a table without a ship, several conditions, or a rudder without terms.

    Parameters
    ----------
    tests : CaptiveTests, StreamedTests, str, Path, DataFrame or Dataset
        Tests of one condition; a path is read as by ``read_captive``, for the ship of ``ship``.
    terms : TermTable or str
        The terms, their bounds and ties, or the name of a table that comes with the package.
    balance : str
        ``tests``: each test counts alike, static or harmonic; ``rows``: each row does, as in the paper.
    accelerations : str
        ``checked``: those of a periodic or straight motion, with a note, where the measured ones stray from it;
        ``motion``: wherever the motion gives them; ``measured``: never.
    errors : RunErrors
        By how much runs differ beyond the noise within them, where the tests hold no repeats that say so.
    pass_over : sequence of str
        Actuators that may move while no term has them: ``rudder``.
    pool : str, optional
        ``depth``: tests at several depths together, with hull coefficients for each and one bank.
    ship : str, Path, Configuration or mapping, optional
        Ship of a table that was not read yet, as of ``read_captive``.
    fixed : mapping of str to float, optional
        Values of coefficients that are not fitted, each in its own SI unit: ``{"b_bank": 0.0}``.
    bounds : mapping of str to two floats, optional
        Bounds of coefficients in place of those of the terms: ``{"b_vdot": (0.0, np.inf)}``.

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
    terms = terms.with_bounds(bounds or {}).with_fixed(fixed or {})
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
    rudder = unmodelled_rudder(equations, terms)
    if rudder and "rudder" not in pass_over:
        raise InputError(f"{rudder}, or fit all the same (--pass-over rudder, in Python pass_over='rudder')")
    if len(equations.tests) < 2:
        raise InputError(f"one row of test {equations.tests[0]} is all there is; standard errors need two or more")
    return Fit(tests, equations, bounded_problem(equations, terms), data_range, errors)


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
    return [float(means[members].mean()) for members in grouped(means)]


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
    return {label: identify(part, **options) for label, part in _conditions(tests, condition).items()}


def the_condition(tests: Tests, condition: str | None) -> Tests:
    parts = _conditions(tests, condition)
    if len(parts) > 1:
        raise InputError(f"the table holds several conditions: choose one with --condition {next(filter(None, parts))}")
    return next(iter(parts.values()))


def _conditions(tests: Tests, condition: str | None) -> Mapping[str, Tests]:
    parts = tests.by_condition() if isinstance(tests, CaptiveTests) else {"": tests}
    if condition is not None and condition not in parts:
        known = [label for label in parts if label]
        hint = did_you_mean(condition, known) if known else "; it names none, select rows instead"
        raise InputError(f"the table has no condition {condition!r}{hint}")
    return parts if condition is None else {condition: parts[condition]}


@cache
def bundled_model(terms: TermTable) -> Model:
    return identify(read_captive(*measured_files("kcs"), ROWS).by_condition()["C0101A02"], terms).model


def bundled_ship(length: float, width: float, depth: float | None = None, terms: TermTable = STEERED) -> Model:
    """Return the KCS as identified from the bundled tests, with its rudder, at another length [m] in sea water."""
    return scale_model(bundled_model(terms), length, 1025.0, width=width, depth=depth).model


# Names of the tables that are compared by default, the last without any bank.
READY_TABLES = (*BARE, *(f"paper+{form}" for form in FORMS if form != "delta"), f"paper+{OPEN_WATER}")
# Joint standard errors between the model's coefficient and the table's beyond which they disagree.
APART_ERRORS = 3.0
# Sizes that distinguish two hulls, and their tolerance [1].
SIZES, SAME_HULL = ("length", "beam", "draft"), 0.01


@dataclass(frozen=True, repr=False)
class Comparison(BaseResult):
    """Fits of several tables of terms to the same tests."""

    fits: Mapping[str, Fit]  #: Fits by the name of the table
    left_out: Mapping[str, str]  #: Tables that were not fitted, and why

    @property
    def best(self) -> dict[str, str]:
        """The table with the smallest error on tests left out, by force."""
        found = {
            f: [(fit.left_out[f].rmse, n) for n, fit in self.fits.items() if f in fit.left_out] for f in self.forces
        }
        return Named({force: min(errors)[1] for force, errors in found.items()})

    @property
    def forces(self) -> tuple[str, ...]:
        """Forces with terms in at least one table."""
        return tuple(dict.fromkeys(force for fit in self.fits.values() for force in fit.scores))

    @property
    def notes(self) -> tuple[str, ...]:
        """Tables that were not fitted, and why."""
        return tuple(f"{name} was not fitted: {reason}." for name, reason in self.left_out.items())

    def summary(self) -> str:
        (first, reference), sentences = next(iter(self.fits.items())), []
        for force in self.forces:
            best = self.best[force]
            other = reference.left_out.get(force) if best != first else None
            against = f"; {first}: {other.rmse:.3g}" if other else ""
            error = f"{self.fits[best].left_out[force].rmse:.3g} {FORCES[force].unit}{against}"
            sentences.append(f"{force}: {best} has the least error on left-out tests, {error}.")
        return "\n".join(sentences)

    def rows(self) -> list[dict[str, Any]]:
        """One row for each table and force."""
        return [_row(name, fit, force) for name, fit in self.fits.items() for force in fit.scores]

    def to_dict(self) -> dict[str, Any]:
        return {
            "tables": self.rows(),
            "tables_left_out": dict(self.left_out),
            "summary": self.summary(),
            "notes": list(self.notes),
        }

    def to_dataframe(self) -> "pd.DataFrame":
        """Give the errors as a table: a row for each table of terms and force."""
        import pandas as pd

        return pd.DataFrame(self.rows()).drop(columns="bank").set_index(["table", "force"])


def _row(table: str, fit: Fit, force: str) -> dict[str, Any]:
    terms, speeds = fit.terms.forces[force], fit.left_out_speeds.get(force)
    value, ends, verdicts = fit.coefficients, fit.intervals, fit.verdicts
    bank = [term.name for term in terms if term.from_bank]
    return {
        "table": table,
        "force": force,
        "coefficients": len(terms),
        "not_separable": sum(verdicts[term.name].status == NOT_SEPARABLE for term in terms),
        "rmse": fit.scores[force].rmse,
        "rmse_left_out": fit.left_out[force].rmse,
        "rmse_other_speeds": speeds.rmse if speeds else float("nan"),
        "bank": {n: {"value": value[n], "ci95": list(ends[n]), "verdict": verdicts[n].status} for n in bank},
    }


@accept_aliases
def compare(
    tests: Any, tables: str | TermTable | Sequence[str | TermTable] = (), balance: Balance = "tests",
    ship: ShipSource | None = None,
) -> Comparison:  # fmt: skip
    """Fit several tables of terms to the same tests.

    Raises an InputError if no table could be fitted, or the tests have no ship.

    Parameters
    ----------
    tests : CaptiveTests, StreamedTests, str, Path, DataFrame or Dataset
        Tests of one condition, or of several for tables with the depth.
    tables : str, TermTable or a sequence of them
        Tables or their names; all bare ones and forms of the bank unless given.
    balance, ship
        As in ``identify``.

    Examples
    --------
    >>> sorted(nw.compare(tests, ("paper", "speed")).fits)
    ['paper', 'speed']
    """
    tests = as_tests(tests, ship)
    fits, left_out = {}, {}
    tables = (tables,) if isinstance(tables, str | TermTable) else tables
    for table in tables or READY_TABLES:
        chosen = table_named(table) if isinstance(table, str) else table
        if chosen.name in fits:
            raise InputError(f"two tables of terms are called {chosen.name!r}; rename one")
        try:
            fits[chosen.name] = identify(tests, chosen, balance, pass_over="rudder")
        except InputError as error:
            left_out[chosen.name] = str(error)
    if not fits:
        raise InputError(f"none of the tables could be fitted: {next(iter(left_out.values()))}")
    return Comparison(fits, left_out)


@dataclass(frozen=True, repr=False)
class Explanation(Scored, BaseResult):
    """A model on a table of tests, whether or not it was fitted on them."""

    model: Model  #: The model
    fit: Fit  #: The same terms fitted to these tests alone
    scores: Mapping[str, Score]  #: Error of the model's own coefficients on these tests
    by_test: Mapping[str, Mapping[str, Score]]  #: The same for each test: test -> force -> score
    comparison: Comparison  #: Other tables of terms on these tests

    def __repr__(self) -> str:
        return f"<Explanation of a model of {self.model.configuration.ship.name or 'a ship'}: {self.fit!r}>"

    @cached_property
    def z_scores(self) -> dict[str, float]:
        """Difference of the model's coefficients from those of these tests [joint standard errors]; NaN if unknown."""
        names, covariance = self.fit.terms.names, self.model.covariance
        columns = self.model.coefficients, self.fit.coefficients, self.fit.std
        own, fitted, std = (np.array([column[name] for name in names]) for column in columns)
        joint = np.sqrt(std**2 + (0.0 if covariance is None else np.diag(covariance)))
        return dict(zip(names, ((own - fitted) / np.where(joint > 0, joint, np.nan)).tolist(), strict=True))

    @property
    def fitted_on_these(self) -> bool:
        """Whether the model was fitted on this table, in this canal."""
        own, tests = self.model, self.fit.tests
        same_canal = own.configuration.canal == tests.configuration.canal
        return bool(own.source.sha256) and own.source.sha256 == tests.source.sha256 and same_canal

    @property
    def notes(self) -> tuple[str, ...]:
        """Conditions of the tests outside the range of the model's data."""
        covered = {name: pair for name, pair in vars(self.fit.data_range).items() if pair is not None}
        return extrapolation(self.model.data_range, covered)

    def summary(self) -> str:
        known, tested, sentences = self.model.ship, self.fit.tests.configuration.ship, []
        if self.fitted_on_these:
            sentences.append("The model was fitted on this table.")
        elif not all(math.isclose(getattr(known, size), getattr(tested, size), rel_tol=SAME_HULL) for size in SIZES):
            ships = f"The model is of {known.in_words}, these tests are of {tested.in_words}"
            sentences.append(f"{ships}: its coefficients are taken as they are, scaled to nothing.")
        for force, fitted in self.scores.items():
            worst, unit = max(self.by_test, key=lambda test: self.by_test[test][force].rmse), FORCES[force].unit
            sentences.append(
                f"{force}: RMS error {fitted.rmse:.3g} {unit} (R2 {fitted.r2:.3f}); {self.fit.scores[force].rmse:.3g} "
                f"for a fit to these tests. It is largest on {worst}, {self.by_test[worst][force].rmse:.3g}."
            )
        apart = ", ".join(name for name, far in self.z_scores.items() if abs(far) > APART_ERRORS)
        if apart and not self.fitted_on_these:
            sentences.append(f"More than {APART_ERRORS:.0f} standard errors from a fit to these tests: {apart}.")
        return "\n".join(sentences)

    def to_dict(self) -> dict[str, Any]:
        return {
            "fitted_on_this_table": self.fitted_on_these,
            "summary": self.summary(),
            "notes": list(self.notes),
            "model": {force: errors._asdict() for force, errors in self.scores.items()},
            "by_test": {test: {f: one.rmse for f, one in scores.items()} for test, scores in self.by_test.items()},
            "distance": dict(self.z_scores),
            "these_tests": self.fit.to_dict(),
            "tables": self.comparison.rows(),
            "tables_left_out": dict(self.comparison.left_out),
        }

    def to_dataframe(self) -> "pd.DataFrame":
        """Give the coefficients as a table: a row each, with the model's value, that of these tests, the distance."""
        import pandas as pd

        columns = {"model": self.model.coefficients, "these_tests": self.fit.coefficients, "distance": self.z_scores}
        frame = pd.DataFrame({name: pd.Series(dict(values)) for name, values in columns.items()})
        return frame.loc[list(self.model.coefficients)].rename_axis("coefficient")


@accept_aliases
def explain(model: Model, tests: Any, tables: Sequence[str] = (), ship: ShipSource | None = None) -> Explanation:
    """Compare a model with a table of tests.

    Raises an InputError if the tests lack a quantity of the model's terms, or are of several conditions.

    Parameters
    ----------
    model : Model
        The model; its terms are fitted to the tests too.
    tests, tables, ship
        As in ``compare``: tests of one condition, tables to compare; the model's own ship unless given.

    Examples
    --------
    >>> sorted(nw.explain(model, tests, ("paper",)).scores)
    ['N', 'X', 'Y']
    """
    tests = as_tests(tests, ship, model.configuration)
    fit = identify(tests, model.terms, pass_over="rudder")
    equations, known = fit.normal_equations, (model.terms, model.coefficients)
    by_test = zip(equations.names, equations.by_test(equations.sums), strict=True)
    scores = {name: score(equations, sums, *known) for name, sums in by_test}
    comparison = compare(tests, (model.terms, *(t for t in tables or READY_TABLES if t != model.terms.name)))
    return Explanation(model, fit, score(equations, equations.total, *known), scores, comparison)
