"""The information that records of a kind are expected to bring, about a ship that is known."""

from dataclasses import dataclass, replace

import numpy as np

from narrows.errors import InputError
from narrows.logbook.filtering.gauss_markov import SWAY, YAW
from narrows.logbook.filtering.search import FIRST_PASSES, SearchResult, scored
from narrows.logbook.learning.log_posterior import LogPosterior, log_posterior
from narrows.logbook.learning.posed_log import PosedLog
from narrows.model.model import Model

TOO_COARSE = (
    "what these sensors read leaves a ship of this size anywhere in its canal, and no fit could follow it; give a "
    "grade of sensors that are finer"
)
LEAST = 0.01  # of usual gusts, how strong gusts are taken to be at least


@dataclass(frozen=True)
class ExpectedInformation:
    """Records of a ship that is taken for known, as a fit would score them."""

    model: Model
    before: np.ndarray  # (n, n) Covariance of its coefficients
    found: SearchResult

    def after(self, count: int) -> LogPosterior:
        """Return what will be known after so many records of the kind."""
        copies = count / len(self.found.records)
        records = tuple(replace(one, information=copies * one.information) for one in self.found.records)
        once = replace(records[0], information=np.sum([one.information for one in records], axis=0))
        return log_posterior(self.model, self.before, replace(self.found, records=(once,)))


def expected_information(model: Model, posed: PosedLog, gusts: np.ndarray, memory: float) -> ExpectedInformation:
    """Score records where the coefficients and the gusts, of covariance (2, 2) and memory [s], are known."""
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
    # The coefficients stay where the ship is known: only the information counts.
    return ExpectedInformation(model, posed.before, replace(found, unknowns=np.zeros(len(unknowns))))
