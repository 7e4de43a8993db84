"""Cross-validation of tables of terms on the same tests and speeds; a model on tests, compared with a fit to them."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError
from narrows.base.results import BaseResult
from narrows.captive.read import as_tests
from narrows.identification.fit import Fit
from narrows.identification.fitting import identify
from narrows.identification.normal_equations import Balance, Score, score
from narrows.identification.verdict import NOT_SEPARABLE
from narrows.model.data_range import extrapolation
from narrows.model.model import Model
from narrows.model.tables import BARE, FORMS, OPEN_WATER, table_named
from narrows.model.term import TermTable
from narrows.quantities.names import FORCES
from narrows.ship.ship_file import ShipSource

if TYPE_CHECKING:
    import pandas as pd

# Joint standard errors between the model's coefficient and the table's beyond which they disagree.
APART_ERRORS = 3.0
# Sizes that distinguish two hulls, and their tolerance [1].
SIZES, SAME_HULL = ("length", "beam", "draft"), 0.01


@dataclass(frozen=True, repr=False)
class Comparison(BaseResult):
    """Fits of several tables of terms to the same tests.

    >>> sorted(nw.compare(tests, ("paper", "speed")).fits)
    ['paper', 'speed']
    """

    fits: Mapping[str, Fit]  #: Fits by the name of the table
    left_out: Mapping[str, str]  #: Tables that were not fitted, and why

    def __repr__(self) -> str:
        return f"<Comparison of {', '.join(self.fits)}>"

    def best(self, force: str) -> str:
        """Return the table with the smallest error of a ``force`` on tests left out."""
        return min((fit.left_out[force].rmse, name) for name, fit in self.fits.items() if force in fit.left_out)[1]

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
            best = self.best(force)
            known = best != first and force in reference.left_out
            against = f"; {first}: {reference.left_out[force].rmse:.3g}" if known else ""
            error = f"{self.fits[best].left_out[force].rmse:.3g} {FORCES[force].unit}{against}"
            sentences.append(f"{force}: {best} has the least error on left-out tests, {error}.")
        return "\n".join(sentences)

    def rows(self) -> list[dict[str, Any]]:
        """One row for each table and force, as plain numbers and words."""
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


def ready_tables() -> tuple[str, ...]:
    """Return the names of the tables to compare by default, the last without any bank."""
    return (*BARE, *(f"paper+{form}" for form in FORMS if form != "delta"), f"paper+{OPEN_WATER}")


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
        Tables or their names; those of ``ready_tables`` unless given.
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
    for table in tables or ready_tables():
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
class Explanation(BaseResult):
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
        model, tests = self.model, self.fit.tests
        same_canal = model.configuration.canal == tests.configuration.canal
        return bool(model.source.sha256) and model.source.sha256 == tests.source.sha256 and same_canal

    @property
    def notes(self) -> tuple[str, ...]:
        """Conditions of the tests outside the range of the model's data."""
        covered = {name: pair for name, pair in vars(self.fit.data_range).items() if pair is not None}
        return extrapolation(self.model.data_range, covered)

    def summary(self) -> str:
        sentences = []
        known, tested = self.model.ship, self.fit.tests.configuration.ship
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
            "by_test": {
                test: {f: errors.rmse for f, errors in scores.items()} for test, scores in self.by_test.items()
            },
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
    tests : CaptiveTests, StreamedTests, str, Path, DataFrame or Dataset
        Tests of one condition.
    tables : sequence of str
        Tables of terms to compare by their errors on left-out tests; those of ``ready_tables`` unless given.
    ship : str, Path, Configuration or mapping, optional
        Ship of tests that were not read yet, as in ``read_captive``; the model's own unless given.

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
    comparison = compare(tests, (model.terms, *(t for t in tables or ready_tables() if t != model.terms.name)))
    return Explanation(model, fit, score(equations, equations.total, *known), scores, comparison)
