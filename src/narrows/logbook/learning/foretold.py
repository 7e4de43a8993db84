"""The information that records of a kind are expected to bring, about a ship that is known."""

import numpy as np

from narrows.errors import InputError
from narrows.logbook.filtering.gauss_markov import SWAY, YAW
from narrows.logbook.filtering.search import FIRST_PASSES, scored
from narrows.logbook.learning.posed_log import PosedLog

TOO_COARSE = (
    "what these sensors read leaves a ship of this size anywhere in its canal, and no fit could follow it; give a "
    "grade of sensors that are finer"
)
LEAST = 0.01  # of usual gusts, how strong gusts are taken to be at least


def expected_information(posed: PosedLog, gusts: np.ndarray, memory: float) -> np.ndarray:
    """Return the information of records at the prior mean, with gusts of covariance (2, 2) and memory [s], (P, P)."""
    problem = posed.problem
    unknowns, usual = np.zeros(len(problem.precision)), {one.name: one for one in problem.model.processes}
    size = np.sqrt(np.diag(gusts)) / problem.inertia.at(problem.prior.mean)[1:]
    strong = dict(zip((SWAY, YAW), size.tolist(), strict=True))
    for place, (of, names, _) in enumerate(problem.model.estimated, start=problem.count):
        if of == "std" and names[0] in strong:
            unknowns[place] = np.log(max(strong[names[0]] / usual[names[0]].std, LEAST))
        elif of == "memory" and SWAY in names:
            unknowns[place] = np.log(memory / usual[SWAY].memory)
        elif of == "correlation":
            product = max(float(np.sqrt(gusts[0, 0] * gusts[1, 1])), np.finfo(float).tiny)
            unknowns[place] = np.arctanh(np.clip(gusts[0, 1] / product, -0.99, 0.99))
    found = scored(problem, posed.source, unknowns, [], FIRST_PASSES)
    if found is None:
        raise InputError(TOO_COARSE)
    return found.information
