"""Tables that hold several conditions, water depths say: one fit for each."""

from typing import Any

from narrows.captive.tests import CaptiveTests, Tests
from narrows.errors import InputError, did_you_mean
from narrows.identification.fit import Fit, identify


def identify_each(tests: Tests, condition: str | None = None, **options: Any) -> dict[str, Fit]:
    """Fit each condition of a table by itself.

    Parameters
    ----------
    tests : CaptiveTests or StreamedTests
        Of one or several conditions.
    condition : str, optional
        Take this one alone.
    **options : Any
        As in ``identify``.

    Returns
    -------
    dict of str to Fit
        By condition; the label is empty where the table names none.

    Raises
    ------
    InputError
        Where there is no such condition.
    """
    parts = tests.by_condition() if isinstance(tests, CaptiveTests) else {"": tests}
    if condition is not None:
        if condition not in parts:
            known = [label for label in parts if label]
            hint = did_you_mean(condition, known) if known else "; it names none, select rows instead"
            raise InputError(f"the table has no condition {condition!r}{hint}")
        parts = {condition: parts[condition]}
    return {label: identify(part, **options) for label, part in parts.items()}
