"""Fit each condition of a table, such as each water depth, by itself."""

from typing import Any

from narrows.captive.measured import measured_files
from narrows.captive.read import as_tests, read_captive
from narrows.captive.tests import CaptiveTests, Tests
from narrows.errors import InputError, did_you_mean
from narrows.identification.fit import Fit
from narrows.identification.fitting import identify
from narrows.model.froude import scale_model
from narrows.model.model import Model
from narrows.ship.ship_file import ShipSource
from narrows.terms.tables import STEERED
from narrows.terms.term import TermTable


def identify_conditions(
    tests: Any, condition: str | None = None, ship: ShipSource | None = None, **options: Any
) -> dict[str, Fit]:
    """Fit each condition of a table by itself.

    Parameters
    ----------
    tests : CaptiveTests, StreamedTests, str, Path, DataFrame or Dataset
        Tests of one or several conditions.
    condition : str, optional
        Take this one alone.
    ship : str, Path, Configuration or mapping, optional
        Ship of a table that was not read yet, as of ``read_captive``.
    **options : Any
        As in ``identify``.

    Returns
    -------
    dict of str to Fit
        By condition; the label is empty where the table names none, or where conditions are pooled.

    Raises
    ------
    InputError
        Where there is no such condition, or a table has no ship.

    Examples
    --------
    >>> sorted(nw.identify_conditions(tests))
    ['C0101A01']
    """
    tests = as_tests(tests, ship)
    if options.get("pool") is not None and condition is None:
        return {"": identify(tests, **options)}
    if condition is not None:
        return {condition: identify(the_condition(tests, condition), **options)}
    parts = tests.by_condition() if isinstance(tests, CaptiveTests) else {"": tests}
    return {label: identify(part, **options) for label, part in parts.items()}


def the_condition(tests: Tests, condition: str | None) -> Tests:
    """Return the tests of one condition."""
    parts = tests.by_condition() if isinstance(tests, CaptiveTests) else {"": tests}
    known = [label for label in parts if label]
    if condition is None:
        if len(parts) > 1:
            raise InputError(f"the table holds several conditions: choose one with --condition {known[0]}")
        return next(iter(parts.values()))
    if condition not in parts:
        hint = did_you_mean(condition, known) if known else "; it names none, select rows instead"
        raise InputError(f"the table has no condition {condition!r}{hint}")
    return parts[condition]


# A ship at full size from the tests that come with the package, for demonstrations.
ROWS = "type in ('PMMY2', 'PMMPSI2', 'STATX0', 'MULTI0') and u_mps > 0.2 and abs(psi_deg) < 20"

# 50 % under the keel; of the water [kg/m3].
CONDITION, DENSITY = "C0101A02", 1025.0


def bundled_ship(length: float, width: float, depth: float | None = None, terms: TermTable = STEERED) -> Model:
    """Return the KCS as identified from the bundled tests, with its rudder, at another size."""
    # length [m]; width [m]; depth [m]
    table, ship = measured_files("kcs")
    fit = identify_conditions(read_captive(table, ship, ROWS), terms=terms)[CONDITION]
    return scale_model(fit.model, length, DENSITY, width=width, depth=depth).model
