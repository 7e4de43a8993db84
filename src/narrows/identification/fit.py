"""The result of a fit; each part is computed when it is first used."""

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import narrows
from narrows.base.errors import InputError
from narrows.base.named_values import Coefficients, Named
from narrows.base.results import BaseResult, same_content
from narrows.captive.read import Tests, as_tests
from narrows.captive.tests import CaptiveTests
from narrows.identification.estimates import (
    Bootstrap,
    CoefficientEstimates,
    DepthTest,
    Predictiveness,
    depth_tests,
    estimates,
    influence,
    predictiveness,
    resampled,
)
from narrows.identification.least_squares import Problem, Solution
from narrows.identification.motions import DistinctMotions, distinct_motions
from narrows.identification.normal_equations import ONE, NormalEquations, Score, Scored, accumulate, score
from narrows.identification.systematic_effects import Effect, RunErrors
from narrows.identification.verdict import IDENTIFIED, Diagnostics, Verdict, implausible, unmodelled_rudder, verdicts
from narrows.model.additions import AT
from narrows.model.data_range import DataRange
from narrows.model.model import Model
from narrows.model.term import TermTable
from narrows.ship.particulars import Configuration
from narrows.ship.ship_file import ShipSource

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@dataclass(frozen=True, repr=False)
class Fit(Scored, BaseResult):
    """A fitted table of terms: estimates, intervals, verdicts and diagnostics.

    >>> fit.verdicts["b_bank"].status
    'not separable'
    """

    tests: Tests  #: The fitted tests
    normal_equations: NormalEquations  #: Sums over the rows
    problem: Problem  #: The terms, their bounds and ties
    data_range: DataRange  #: Ranges that the rows cover
    errors: RunErrors  #: Prior sizes of the differences between runs beyond their noise
    __eq__ = same_content

    def __repr__(self) -> str:
        return f"<Fit of {self.terms.name}: {len(self.terms.names)} coefficients, {self._size}>"

    def __getitem__(self, name: str) -> float:
        """The value of a coefficient [SI]."""
        return self.model[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.terms.names)

    @property
    def terms(self) -> TermTable:
        """The terms."""
        return self.problem.terms

    @cached_property
    def coefficients(self) -> dict[str, float]:
        """Estimates of the mixed model within the bounds, each in its term's SI unit: the model's values."""
        return Coefficients(zip(self.terms.names, self.estimates.values.tolist(), strict=True))

    @property
    def nobs(self) -> int:
        """Number of rows of the fit."""
        return round(float(self.normal_equations.pick(self.normal_equations.total, [ONE])[0, 0]))

    @cached_property
    def motions(self) -> DistinctMotions:
        """The distinct motions, which the standard errors treat as independent."""
        return distinct_motions(self.normal_equations)

    @cached_property
    def solution(self) -> Solution:
        """The optimum of the paper's problem, with its Karush-Kuhn-Tucker check."""
        return self.problem.solve(self.normal_equations.total)

    @property
    def least_squares(self) -> dict[str, float]:
        """The optimum of the paper's constrained problem, by rows alone, each in its term's SI unit."""
        return self.problem.named(self.solution.z)

    @property
    def at_bound(self) -> tuple[str, ...]:
        """Coefficients at a bound."""
        bounds, slot = self.problem.bounds, self.problem.slot
        return tuple(name for name, value in self.coefficients.items() if value in bounds[slot[name]])

    @property
    def vif(self) -> dict[str, float]:
        """Variance inflation factor of each coefficient among those of its force, over all rows [1]."""
        parts = self.diagnostics.overall.values()
        return Named({name: factor for own in parts for name, factor in own.vif.items()})

    @property
    def condition_number(self) -> dict[str, float]:
        """Condition number of each force's columns, each scaled to unit length [1]."""
        return Named({force: part.condition for force, part in self.diagnostics.overall.items()})

    @property
    def model(self) -> Model:
        """The fit as a model, ready to save or to simulate."""
        verdicts = {name: verdict.words for name, verdict in self.verdicts.items()}
        known = self.coefficients, self.estimates.covariance, self.data_range, self.tests.source, verdicts
        return Model(self.tests.configuration, self.terms, *known)

    @cached_property
    def scores(self) -> dict[str, Score]:
        """R2 and RMSE of each force on the rows of the fit, with the weights of the fit."""
        return self.score()

    @cached_property
    def left_out(self) -> dict[str, Score]:
        """R2 and RMSE of each force by cross-validation: on distinct motions, left out in turn."""
        if len(self.motions) < 2:
            return dict.fromkeys(self.scores, Score(float("nan"), float("nan")))
        others = self.problem.fits(self.motions.without)
        return score(self.normal_equations, self.motions.sums, self.terms, others)

    @cached_property
    def left_out_speeds(self) -> dict[str, Score]:
        """Scores at each speed of a fit to the other speeds; empty for one speed."""
        groups = np.stack([self.motions.sums[members].sum(axis=0) for members in self.motions.by_speed])
        if len(groups) < 2:
            return {}
        others = self.problem.fits(groups.sum(axis=0) - groups)
        return score(self.normal_equations, groups, self.terms, others)

    @cached_property
    def estimates(self) -> CoefficientEstimates:
        """The posterior of the mixed model: estimates, intervals, tipping points, and how large each error is."""
        return estimates(*self._known)

    @property
    def error_scales(self) -> dict[str, dict[str, float]]:
        """Sizes of the errors of runs and of the campaign, by the forces that are fitted together."""
        return {" and ".join(part.rows.forces): part.scales for part in self.estimates.forces}

    @cached_property
    def predictiveness(self) -> tuple[Predictiveness, ...]:
        """Prediction errors on left-out motions, by force."""
        parts = self.estimates.forces if len(self.motions) > 1 else ()
        return tuple(one for part in parts for one in predictiveness(part))

    @property
    def covariance(self) -> "pd.DataFrame":
        """Covariance (n, n) of the coefficients within their bounds, by their names.

        Ensembles and the envelope draw from it; it is zero for coefficients held at a bound.
        """
        import pandas as pd

        return pd.DataFrame(self.estimates.covariance, self.terms.names, self.terms.names)

    @cached_property
    def std(self) -> dict[str, float]:
        """Standard error of each coefficient with errors of runs; NaN where tests do not determine it, 0 if fixed."""
        sizes, known = zip(self.terms.names, self.estimates.std.tolist(), strict=True), self.diagnostics.determined
        return Named({name: size if not size or known(name) else float("nan") for name, size in sizes})

    @cached_property
    def intervals(self) -> dict[str, tuple[float, float]]:
        """95 % interval of each coefficient within its bounds; the bounds where it is not determined."""
        pairs = zip(self.terms.terms, self.estimates.ends.tolist(), strict=True)
        known = self.diagnostics.determined
        return {term.name: (ends[0], ends[1]) if known(term.name) else term.bound for term, ends in pairs}

    @cached_property
    def diagnostics(self) -> Diagnostics:
        """Rank, condition, VIF and correlations of each force's columns: ``overall``, ``by_test`` and ``by_speed``."""
        return Diagnostics(self.normal_equations, self.terms, self.motions)

    @cached_property
    def verdicts(self) -> dict[str, Verdict]:
        """Verdict on each coefficient."""
        return verdicts(self.diagnostics, self.estimates, self.left_out)

    @cached_property
    def implausible(self) -> tuple[str, ...]:
        """Implausible results, each a sentence with its likely cause: masses, signs of forces and rudder."""
        return implausible(self)

    @cached_property
    def depth_tests(self) -> dict[str, DepthTest]:
        """Test of each bank coefficient for equality at all depths; empty for one depth."""
        return depth_tests(*self._known)

    @cached_property
    def influence(self) -> "pd.DataFrame":
        """Share of the information on each coefficient that is gone without a distinct motion: a row for each [1]."""
        return influence(self.motions, self.estimates)

    def bootstrap(self, resamples: int = 10_000, seed: int = 0) -> Bootstrap:
        """Draw distinct motions with replacement, each with all its repeats, and fit under the constraints.

        ``resamples`` is the number of draws, and ``seed`` starts the generator. Raises an InputError where there are
        fewer than 2 resamples.
        """
        return resampled(self.problem, self.motions, self.estimates, resamples, seed)

    def shapley(self) -> dict[str, dict[str, float]]:
        """Shapley value of each term, over the sum of their sizes: force -> coefficient -> share.

        The worth of a set of terms is minus its mean squared error with the fitted coefficients.
        """
        # The game is quadratic, which gives a closed form: theta_j (2 x_j'y - x_j'X theta), up to a factor.
        equations, shared = self.normal_equations, {}
        for force in self.scores:
            names = [term.name for term in self.terms.forces[force]]
            values = np.array([self.coefficients[name] for name in names])
            cross = equations.pick(equations.total, names, [force])[:, 0]
            phi = values * (2 * cross - equations.pick(equations.total, names) @ values)
            shared[force] = dict(zip(names, (phi / max(np.abs(phi).sum(), 1e-300)).tolist(), strict=True))
        return shared

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes of the reader of the tests, and the tests taken as independent."""
        alone = "These tests are one motion: none can be left out, and no left-out error is known."
        shared = "Terms that do not depend on the depth have one coefficient for all conditions of these tests."
        several = isinstance(self.tests, CaptiveTests) and len(set(self.tests.conditions)) > 1
        rudder = unmodelled_rudder(self.normal_equations, self.terms)
        notes = (
            self.motions.sentence,
            alone * (len(self.motions) < 2),
            shared * (several and AT not in self.terms.name),
            *(test.sentence(name) for name, test in self.depth_tests.items()),
            "" if self.terms.has_bank else self.terms.bank_note,
            f"{rudder[:1].upper()}{rudder[1:]}." if rudder else "",
        )
        return (*self.tests.notes, *filter(None, notes))

    def predict(self, tests: Any = None, ship: ShipSource | None = None) -> "pd.DataFrame":
        """Estimate surge force [N], sway force [N] and yaw moment [N m] at each row of the fit.

        Or at those of other ``tests``, read for a ``ship`` where they were not read yet.
        """
        read = self.tests if tests is None else as_tests(tests, ship, self.tests.configuration)
        return read.force_rows(self.terms, self.coefficients)

    @property
    def residuals(self) -> "pd.DataFrame":
        """Measured less estimated surge force [N], sway force [N] and yaw moment [N m], at each row of the fit."""
        return self.tests.force_rows(self.terms, self.coefficients, measured=True)

    def score(self, tests: Any = None, ship: ShipSource | None = None) -> dict[str, Score]:
        """Return R2 and RMSE of each force on other ``tests``, read for a ``ship`` where they were not read yet."""
        equations = self.normal_equations
        if tests is not None:
            read = as_tests(tests, ship, self.tests.configuration)
            equations, _ = accumulate(read, self.terms, balance=equations.balance)
        return score(equations, equations.total, self.terms, self.coefficients)

    def plot_forces(self) -> "Figure":
        """Draw the measured and the estimated forces of all tests, and the bank's part.

        Raises an InputError for streamed tests.
        """
        if not isinstance(self.tests, CaptiveTests):
            raise InputError("streamed tests are too many to draw; draw those of fit.predict(part)")
        return narrows.report.forces_figure(self, self.tests)

    def plot_residuals(self, ax: "Axes | None" = None, force: str | None = None) -> "Figure":
        """Draw the residuals of each force over its estimates, a colour for each test.

        With Axes ``ax``, one ``force`` is drawn there, ``X``, ``Y`` or ``N``; the first unless given. Raises an
        InputError where the fit has no such force.
        """
        return narrows.report.residuals_figure(self, ax, force)

    def report(self, path: str | Path, title: str = "narrows") -> None:
        """Write one HTML page with a ``title`` to a ``path``: everything that is known of it, its answer first."""
        narrows.report.write_report({"": self}, path, title)

    def save(self, path: str | Path) -> None:
        """Write it in the format of the suffix; ``.toml`` is its model, which ``load_model`` reads."""
        if Path(path).suffix == ".toml":
            self.model.save(path)
        else:
            super().save(path)

    def summary(self) -> str:
        scores = [
            f"{force}: R2 {fitted.r2:.3f}, RMSE {fitted.rmse:.3g}; on left-out tests "
            f"R2 {self.left_out[force].r2:.3f}, RMSE {self.left_out[force].rmse:.3g}."
            for force, fitted in self.scores.items()
        ]
        doubts = [verdict.sentence(name) for name, verdict in self.verdicts.items() if verdict.status != IDENTIFIED]
        title = f"{len(self.terms.names)} coefficients of the terms {self.terms.name} on {self._size}."
        return "\n".join([title, *self.implausible, *scores, *doubts, "", self.to_dataframe().to_string()])

    def to_dict(self) -> dict[str, Any]:
        return {
            "coefficients": {name: self._coefficient(name) for name in self.terms.names},
            "fit": {
                force: fitted._asdict() | {f"{n}_left_out": v for n, v in self.left_out[force]._asdict().items()}
                for force, fitted in self.scores.items()
            },
            "diagnostics": {force: diagnosis.to_dict() for force, diagnosis in self.diagnostics.overall.items()},
            "by_speed": [
                {"speed": speed, "diagnostics": {force: d.to_dict() for force, d in by_force.items()}}
                for speed, by_force in self.diagnostics.by_speed.items()
            ],
            "shapley": self.shapley(),
            "kkt": {"satisfied": self.solution.kkt.satisfied, **self.solution.kkt._asdict()},
            "influence": {
                name: {"most_informing": share.idxmax(), "share": float(share.max())}
                for name, share in self.influence.items()
            },
            "predictiveness": [asdict(one) for one in self.predictiveness],
            "error_scales": self.error_scales,
            "implausible": list(self.implausible),
            "notes": list(self.notes),
        }

    def to_dataframe(self) -> "pd.DataFrame":
        """Return a table of the coefficients with value, std, low, high, unit and verdict."""
        import pandas as pd

        rows = [
            (name, self.coefficients[name], self.std[name], *self.intervals[name], self.terms[name].dimension.unit,
             self.verdicts[name].status)
            for name in self.terms.names
        ]  # fmt: skip
        columns = ["coefficient", "value", "std", "low", "high", "unit", "verdict"]
        return pd.DataFrame(rows, columns=columns).set_index("coefficient")

    def _coefficient(self, name: str) -> dict[str, Any]:
        verdict = self.verdicts[name]
        return {
            "value": self.coefficients[name],
            "std": self.std[name],
            "ci95": list(self.intervals[name]),
            "unit": self.terms[name].dimension.unit,
            "determined": verdict.determined,
            "verdict": verdict.status,
            "not_separable_from": list(verdict.partners),
            "reasons": list(verdict.reasons),
            "tipping_points": _errors(self.estimates.tipping[name]),
            "limits": _errors(self.estimates.limits[name]),
        }

    @property
    def _known(self) -> tuple[NormalEquations, DistinctMotions, Problem, RunErrors, Configuration]:
        return self.normal_equations, self.motions, self.problem, self.errors, self.tests.configuration

    @property
    def _size(self) -> str:
        return f"{len(self.normal_equations.names)} tests of {self.nobs} rows"


def _errors(sizes: list[tuple[Effect, float]]) -> list[dict[str, Any]]:
    return [{"error": e.name, "size": size, "unit": e.unit, "usual": e.usual} for e, size in sizes]
