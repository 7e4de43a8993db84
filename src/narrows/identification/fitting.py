"""``identify``: tests in, a fit out."""

from narrows.captive.split import random_split
from narrows.captive.tests import CaptiveTests, Tests
from narrows.errors import InputError, check_choice, check_count, shown
from narrows.identification.cross_validation import left_out_coefficients, left_out_score
from narrows.identification.fit import Fit
from narrows.identification.regression.accumulation import accumulate
from narrows.identification.regression.problem import reduced
from narrows.identification.regression.scores import score
from narrows.identification.regression.solve import solve
from narrows.identification.uncertainty.clusters import clustered, pieces_for
from narrows.terms.tables import PAPER, table_named
from narrows.terms.term import TermTable

SPLITS = ("test", "random")


def identify(
    tests: Tests, terms: TermTable | str = PAPER, weights: str = "paper", split: str = "test", seed: int = 0
) -> Fit:
    """Fit a table of terms to captive tests: the paper's joint constrained problem, solved exactly.

    One pass over the rows leaves sums of products; the fit, its standard errors (cluster jackknife) and its
    left-out scores all come from these.

    Parameters
    ----------
    tests : CaptiveTests or StreamedTests
        Of one condition.
    terms : TermTable or str
        The terms, their bounds and ties, or the name of a table that comes with the package.
    weights : str
        ``paper``: the plain sum of squared errors of X, Y and N; ``variance``: each over its force's variance.
    split : str
        ``test``: fit on every row, check on each test left out in turn; ``random``: fit on a seeded random
        80 % of the rows, check on the rest, as the paper does.
    seed : int
        Of the random split.

    Returns
    -------
    Fit
        With ``coefficients``, ``std``, ``intervals``, ``verdicts``, ``scores``, ``left_out`` and ``model``.

    Raises
    ------
    InputError
        Where an option is unknown or the tests are of several conditions.
    """
    check_choice("split", split, SPLITS)
    check_count("seed", seed)
    terms = table_named(terms) if isinstance(terms, str) else terms
    if not isinstance(terms, TermTable):
        raise InputError(f"terms = {shown(terms)} is no table of terms; give one, or the name of one")
    check_one_condition(tests, terms)
    fitted, checked = random_split(tests, seed=seed) if split == "random" else (tests, None)
    equations, data_range = accumulate(fitted, terms, pieces_for(len(tests.names)))
    problem = reduced(equations, terms, weights)
    solution = solve(*problem.normal(equations.total), problem.lower, problem.upper)
    clusters = clustered(equations)
    if checked is None:
        without = left_out_coefficients(problem, clusters.without)
        left_out = left_out_score(equations, terms, clusters.sums, without)
    else:
        rest, _ = accumulate(checked, terms)
        left_out = score(rest, rest.total, terms, problem.named(solution.z))
    return Fit(fitted, equations, problem, solution, clusters, left_out, split, data_range)


def check_one_condition(tests: Tests, terms: TermTable) -> None:
    """Raise where tests at several depths are to share coefficients that do not know the depth (ours).

    Parameters
    ----------
    tests : CaptiveTests or StreamedTests
        The rows.
    terms : TermTable
        The terms.

    Raises
    ------
    InputError
        Names the conditions.
    """
    if isinstance(tests, CaptiveTests) and len(set(tests.conditions)) > 1 and not terms.feels_depth:
        labels = ", ".join(dict.fromkeys(tests.conditions))
        raise InputError(
            f"the tests are of several conditions ({labels}), which no one model fits unless its terms ask for the "
            "depth; identify each of tests.by_condition()"
        )
