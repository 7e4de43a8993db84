"""Compare tables of terms on the same tests by cross-validation: errors on left-out tests and speeds."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from narrows.captive.read import as_tests
from narrows.errors import InputError
from narrows.identification.fit import Fit
from narrows.identification.fitting import identify
from narrows.identification.least_squares import Weights
from narrows.identification.normal_equations import Balance
from narrows.identification.verdict import NOT_SEPARABLE
from narrows.quantities.names import FORCES
from narrows.results import BaseResult
from narrows.ship.ship_file import ShipSource
from narrows.terms.bank_forms import FORMS, OPEN_WATER
from narrows.terms.tables import BARE, table_named
from narrows.terms.term import TermTable

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, repr=False)
class Comparison(BaseResult):
    """Fits of several tables of terms to the same tests.

    Parameters
    ----------
    fits : mapping of str to Fit
        By the table's name.
    left_out : mapping of str to str
        Tables that were not fitted, and why.

    Examples
    --------
    >>> sorted(nw.compare(tests, ("paper", "speed")).fits)
    ['paper', 'speed']
    """

    fits: Mapping[str, Fit]
    left_out: Mapping[str, str]

    def __repr__(self) -> str:
        return f"<Comparison of {', '.join(self.fits)}>"

    def best(self, force: str) -> str:
        """Return the table with the smallest error on tests left out.

        Parameters
        ----------
        force : str
            ``X``, ``Y`` or ``N``.
        """
        judged = {name: fit.left_out[force].rmse for name, fit in self.fits.items() if force in fit.left_out}
        return min(judged, key=lambda name: judged[name])

    @property
    def forces(self) -> tuple[str, ...]:
        """The forces that some table has terms for."""
        return tuple(dict.fromkeys(force for fit in self.fits.values() for force in fit.scores))

    @property
    def notes(self) -> tuple[str, ...]:
        """Tables that were not fitted, and why."""
        return tuple(f"{name} was not fitted: {reason}." for name, reason in self.left_out.items())

    def summary(self) -> str:
        """Best table for each force on left-out tests, compared with the first table: a line each."""
        first = next(iter(self.fits))
        sentences = []
        for force in self.forces:
            best = self.best(force)
            errors = {n: fit.left_out[force].rmse for n, fit in self.fits.items() if force in fit.left_out}
            against = f"; {first}: {errors[first]:.3g}" if best != first and first in errors else ""
            error = f"{errors[best]:.3g} {FORCES[force].unit}{against}"
            sentences.append(f"{force}: {best} has the least error on left-out tests, {error}.")
        return "\n".join(sentences)

    def rows(self) -> list[dict[str, Any]]:
        """One row for each table and force, as plain numbers and words."""
        return [_row(name, fit, force) for name, fit in self.fits.items() for force in fit.scores]

    def to_dict(self) -> dict[str, Any]:
        """Give the tables and their errors by name."""
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


def _row(name: str, fit: Fit, force: str) -> dict[str, Any]:
    names = [term.name for term in fit.terms.forces[force]]
    bank = [term.name for term in fit.terms.forces[force] if term.from_bank]
    speeds = fit.left_out_speeds.get(force)
    return {
        "table": name,
        "force": force,
        "coefficients": len(names),
        "not_separable": sum(fit.verdicts[name].status == NOT_SEPARABLE for name in names),
        "rmse": fit.scores[force].rmse,
        "rmse_left_out": fit.left_out[force].rmse,
        "rmse_other_speeds": speeds.rmse if speeds else float("nan"),
        "bank": {
            name: {
                "value": fit.coefficients[name],
                "ci95": list(fit.intervals[name]),
                "verdict": fit.verdicts[name].status,
            }
            for name in bank
        },
    }


def ready_tables() -> tuple[str, ...]:
    """Return the names of the tables to compare where none are asked for, the last without any bank."""
    return (*BARE, *(f"paper+{form}" for form in FORMS if form != "delta"), f"paper+{OPEN_WATER}")


def compare(
    tests: Any, tables: str | TermTable | Sequence[str | TermTable] = (), weights: Weights = "paper",
    balance: Balance = "tests",
    ship: ShipSource | None = None,
) -> Comparison:  # fmt: skip
    """Fit several tables of terms to the same tests.

    Parameters
    ----------
    tests : CaptiveTests, StreamedTests, str, Path, DataFrame or Dataset
        Tests of one condition, or of several for tables with the depth.
    tables : str, TermTable or a sequence of them
        Tables, or names of them; those of ``ready_tables`` unless given.
    weights, balance : str
        As in ``identify``.
    ship : str, Path, Configuration or mapping, optional
        Ship of a table that was not read yet, as of ``read_captive``.

    Raises
    ------
    InputError
        Where no table could be fitted, or a table of tests has no ship.

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
            fits[chosen.name] = identify(tests, chosen, weights, balance, pass_over="rudder")
        except InputError as error:
            left_out[chosen.name] = str(error)
    if not fits:
        raise InputError(f"none of the tables could be fitted: {next(iter(left_out.values()))}")
    return Comparison(fits, left_out)
