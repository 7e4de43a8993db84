"""``explain``: the errors of a model on a table of tests, and what a fit to that table gives instead."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.captive.read import as_tests
from narrows.identification.comparison import Comparison, compare, ready_tables
from narrows.identification.fit import Fit
from narrows.identification.fitting import identify
from narrows.identification.normal_equations import Score, score
from narrows.identification.shapley import KINDS
from narrows.model.data_range import extrapolation
from narrows.model.model import Model
from narrows.quantities.names import FORCES
from narrows.results import BaseResult
from narrows.ship.ship_file import ShipSource

if TYPE_CHECKING:
    import pandas as pd

# Joint standard errors between the model's coefficient and the table's beyond which they disagree.
APART_ERRORS = 3.0
# Sizes that distinguish two hulls, and their tolerance [1].
SIZES, SAME_HULL = ("length", "beam", "draft"), 0.01


@dataclass(frozen=True, repr=False)
class Explanation(BaseResult):
    """A model on a table of tests, that it was fitted on or not.

    Parameters
    ----------
    model : Model
        The model.
    fit : Fit
        The same terms fitted to these tests alone.
    scores : mapping of str to Score
        Error of the model's own coefficients on these tests.
    by_test : mapping of str to mapping of str to Score
        The same by test: test -> force -> score.
    comparison : Comparison
        Other tables of terms on these tests.
    """

    model: Model
    fit: Fit
    scores: Mapping[str, Score]
    by_test: Mapping[str, Mapping[str, Score]]
    comparison: Comparison

    def __repr__(self) -> str:
        return f"<Explanation of a model of {self.model.configuration.ship.name or 'a ship'}: {self.fit!r}>"

    @cached_property
    def shares(self) -> dict[str, dict[str, dict[str, float]]]:
        """Shapley shares of the model's own coefficients on these tests: kind -> force -> coefficient -> share."""
        return {kind: self.fit.shapley(kind, self.model.coefficients) for kind in KINDS}

    @cached_property
    def distance(self) -> dict[str, float]:
        """Distance of the model's coefficients from those of these tests, in joint standard errors; NaN if unknown."""
        covariance = self.model.covariance
        variances = 0.0 if covariance is None else np.diag(covariance)
        names = self.fit.terms.names
        own, other, std = (
            [part[n] for n in names] for part in (self.model.coefficients, self.fit.coefficients, self.fit.std)
        )
        joint = np.sqrt(np.square(std) + variances)
        distances = np.subtract(own, other) / np.where(joint > 0, joint, np.nan)
        return dict(zip(names, distances.tolist(), strict=True))

    @property
    def fitted_on_these(self) -> bool:
        """Whether the model came of this very table, at this depth."""
        model, tests = self.model, self.fit.tests
        same_canal = model.configuration.canal == tests.configuration.canal
        return bool(model.source.sha256) and model.source.sha256 == tests.source.sha256 and same_canal

    @property
    def notes(self) -> tuple[str, ...]:
        """Conditions of the tests outside the range of the model's data."""
        covered = {name: pair for name, pair in vars(self.fit.data_range).items() if pair is not None}
        return extrapolation(self.model.data_range, covered)

    def summary(self) -> str:
        """Error of the model on these tests, where it is largest, and which coefficients differ: a line each."""
        sentences = ["The model was fitted on this table."] if self.fitted_on_these else self._another_ship()
        for force, fitted in self.scores.items():
            worst, unit = max(self.by_test, key=lambda test: self.by_test[test][force].rmse), FORCES[force].unit
            sentences.append(
                f"{force}: RMS error {fitted.rmse:.3g} {unit} (R2 {fitted.r2:.3f}); {self.fit.scores[force].rmse:.3g} "
                f"for a fit to these tests. It is largest on {worst}, {self.by_test[worst][force].rmse:.3g}."
            )
        apart = [name for name, far in self.distance.items() if abs(far) > APART_ERRORS]
        if apart and not self.fitted_on_these:
            sentences.append(
                f"More than {APART_ERRORS:.0f} standard errors from a fit to these tests: {', '.join(apart)}."
            )
        return "\n".join(sentences)

    def _another_ship(self) -> list[str]:
        """Warning where the tests are of another hull than the model."""
        known, tested = self.model.ship, self.fit.tests.configuration.ship
        if all(math.isclose(getattr(known, size), getattr(tested, size), rel_tol=SAME_HULL) for size in SIZES):
            return []
        taken = "its coefficients are taken as they are, scaled to nothing"
        return [f"The model is of {known.in_words}, these tests are of {tested.in_words}: {taken}."]

    def to_dict(self) -> dict[str, Any]:
        """Give everything by name: what ``explain --json`` prints."""
        return {
            "fitted_on_this_table": self.fitted_on_these,
            "summary": self.summary(),
            "notes": list(self.notes),
            "model": {force: errors._asdict() for force, errors in self.scores.items()},
            "by_test": {
                test: {force: errors.rmse for force, errors in scores.items()} for test, scores in self.by_test.items()
            },
            "distance": dict(self.distance),
            "shapley": self.shares,
            "these_tests": self.fit.to_dict(),
            "tables": self.comparison.rows(),
            "tables_left_out": dict(self.comparison.left_out),
        }

    def to_dataframe(self) -> "pd.DataFrame":
        """Give the coefficients as a table: a row each, the model's, that of these tests, how far apart they are."""
        import pandas as pd

        rows = {
            name: (value, self.fit.coefficients[name], self.distance[name])
            for name, value in self.model.coefficients.items()
        }
        columns = ["model", "these_tests", "distance"]
        return pd.DataFrame.from_dict(rows, orient="index", columns=columns).rename_axis("coefficient")


def explain(model: Model, tests: Any, tables: Sequence[str] = (), ship: ShipSource | None = None) -> Explanation:
    """Put a model and a table of tests beside each other.

    Parameters
    ----------
    model : Model
        The model; its terms are fitted to the tests too.
    tests : CaptiveTests, StreamedTests, str, Path, DataFrame or Dataset
        Tests of one condition.
    tables : sequence of str
        Tables of terms to compare by what they say of tests left out; all that come with the package unless given.
    ship : str, Path, Configuration or mapping, optional
        Ship of a table that was not read yet, as of ``read_captive``; the model's own unless given.

    Returns
    -------
    Explanation
        Errors of the model, the fit to these tests with all that is known of it, Shapley shares, other tables.

    Raises
    ------
    InputError
        Where the tests lack what the model's terms need, or are of several conditions.

    Examples
    --------
    >>> sorted(nw.explain(model, tests, ("paper",)).scores)
    ['N', 'X', 'Y']
    """
    tests = as_tests(tests, ship, model.configuration)
    fit = identify(tests, model.terms, pass_over="rudder")
    equations = fit.normal_equations
    return Explanation(
        model,
        fit,
        score(equations, equations.total, model.terms, model.coefficients),
        {
            name: score(equations, sums, model.terms, model.coefficients)
            for name, sums in zip(equations.names, equations.by_test(equations.sums), strict=True)
        },
        compare(tests, (model.terms, *(t for t in tables or ready_tables() if t != model.terms.name))),
    )
