"""What records of a kind will teach before there are any: the equations of a fit, about a ship that is known."""

from dataclasses import dataclass, replace

import numpy as np

from narrows.errors import InputError
from narrows.logbook.learning.log_posterior import LogPosterior, log_posterior
from narrows.logbook.learning.posed_log import PosedLog
from narrows.logbook.learning.refined_search import begun, sampled
from narrows.logbook.shooting.chain_likelihood import GustJudge, gust_doubt
from narrows.logbook.shooting.log_search import found_at
from narrows.logbook.shooting.push_chain import SWAY, YAW
from narrows.logbook.shooting.search_state import samples_of
from narrows.model.model import Model

TOO_COARSE = (
    "what these sensors read leaves a ship of this size anywhere in her canal, and no fit could follow it; give a "
    "grade of sensors that are finer"
)
# Of usual gusts, how strong gusts are taken to be at least.
LEAST = 0.01


@dataclass(frozen=True)
class ForetoldRecords:
    """Records of a ship that is taken for known, as a fit would look at them where it is done."""

    model: Model  # The ship
    before: np.ndarray  # (n, n) Covariance of its coefficients
    judge: GustJudge  # What the records say of gusts, with all else that they say
    count: int  # How many records these are

    def after(self, count: int) -> LogPosterior:
        """Return what will be known after so many records of the kind."""
        copies = count / self.count
        doubt = gust_doubt(self.judge, copies)
        found = self.judge.found.repeated(copies)
        return log_posterior(self.model, self.before, self.judge.problem.prior, found, doubt)


def foretold_records(model: Model, posed: PosedLog, gusts: np.ndarray, memory: float) -> ForetoldRecords:
    """Look at records where the coefficients and the gusts are known, as a fit does where it is done."""
    # gusts (2, 2); memory [s]
    problem, usual = posed.problem, posed.problem.chain
    size = np.sqrt(np.diag(gusts))
    pushes = [usual.names.index(name) for name in (SWAY, YAW)]
    strength = np.maximum(size / problem.inertia.at(problem.prior.mean)[1:], LEAST * usual.std[pushes])
    correlation = float(gusts[0, 1] / max(size.prod(), np.finfo(float).tiny))
    strong = dict(zip((SWAY, YAW), strength.tolist(), strict=True))
    problem = replace(problem, chain=usual.with_pushes(strong, memory, correlation))
    known = np.zeros(len(problem.prior.groups))
    states = begun(problem, posed.source, known)
    found = found_at(problem, known, posed.source, states, sampled(len(states), True))
    if found is None:
        raise InputError(TOO_COARSE)
    judge = GustJudge(problem, found, samples_of(posed.source, found, states), usual)
    return ForetoldRecords(model, posed.before, judge, len(states))
