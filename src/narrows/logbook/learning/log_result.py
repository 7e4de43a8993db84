"""Compute the answer from a finished search."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from narrows.logbook.filtering.gauss_markov import SWAY, YAW
from narrows.logbook.filtering.likelihood import RecordScore
from narrows.logbook.filtering.log_problem import LogProblem
from narrows.logbook.filtering.predicted_signals import HELM
from narrows.logbook.filtering.search import LOOSE_WALK, SearchResult
from narrows.logbook.learned_coefficient import learned_coefficients, learned_model
from narrows.logbook.learning.log_fit import Gusts, LogFit, SignalNoise
from narrows.logbook.learning.log_posterior import LogPosterior, averaged, log_posterior
from narrows.logbook.learning.log_setup import LogSetup
from narrows.logbook.learning.log_source import LogSource
from narrows.logbook.learning.record_answers import RecordAnswer, record_answers
from narrows.model.data_range import Range
from narrows.model.model import Model
from narrows.terms.term import TermKind

STRETCHES = (
    "The model does not fit whole records and was fitted to short stretches. Do not predict whole manoeuvres with it."
)


def log_result(
    posed: LogSetup, found: SearchResult, log: LogSource, free: Sequence[str], piloted: SearchResult | None = None
) -> LogFit:
    """Return the answer of a search, averaged with that of one with a pilot where there is one."""
    source, prior = posed.source, replace(posed.model, covariance=posed.before)
    after = _posterior(posed, found)
    apart: tuple[str, ...] = ()
    if piloted is not None and piloted.records and not (piloted.diverged or piloted.interrupted):
        given, joint = after, _posterior(posed, piloted)
        after, apart = averaged(given, joint), rudder_matters(posed.model, given, joint)
    learned = learned_coefficients(prior, after.values, after.covariance)
    answers = record_answers(found, source)
    came = learned_model(prior, learned, after.covariance, "", *_ranges(found.records))
    stopped = (
        f"The search was interrupted after {found.steps} steps; the result is from {len(found.records)} records.",
    )
    about = (
        *apart,
        *(STRETCHES,) * (found.problem.walk == LOOSE_WALK),
        *said_granted(found.problem, free, answers),
        *source.left_out,
        *stopped * found.interrupted,
    )
    return LogFit(
        replace(came, source=log.after(prior, len(answers))), prior, learned, answers, _gusts(found), _noise(found),
        after.disagreement, after.freedom, after.probability, _inertia(posed.model, found.problem), about,
        found.converged,
    )  # fmt: skip


def _posterior(posed: LogSetup, found: SearchResult) -> LogPosterior:
    scores = np.stack([one.score for one in found.records])
    return log_posterior(posed.model, posed.before, found.problem, found.unknowns, found.information, scores)


def rudder_matters(model: Model, given: LogPosterior, joint: LogPosterior) -> tuple[str, ...]:
    """Return the bank coefficients that depend on whether the rudder is an input or the order of a pilot."""
    # Hausman (1978), Specification tests in econometrics, Econometrica 46: of the two only the second is consistent
    # where the pilot sees more than the log.
    return tuple(
        f"{name} is {one:.3g} if the rudder is taken as given and {other:.3g} with a pilot's law, more than a standard "
        "error apart: the pilot may see more than the log. Its interval includes both."
        for name, one, other, variance in zip(
            model.terms.names, given.values, joint.values, np.diag(given.covariance), strict=True
        )
        if model.terms[name].from_bank and abs(one - other) > math.sqrt(variance)
    )


def _inertia(model: Model, problem: LogProblem) -> tuple[str, ...]:
    """Coefficients of the inertia in the motion, one for each group of ties."""
    seconds = {second for _, second in model.terms.ties}
    surge = problem.motion.integrator.ship.surge
    acting = [term for force, terms in model.terms.forces.items() if force != "X" or surge == "free" for term in terms]
    return tuple(term.name for term in acting if term.kind == TermKind.INERTIA and term.name not in seconds)


def _ranges(records: Iterable[RecordScore]) -> tuple[Range, Range]:
    """Ranges of distance from the centreline and of speed."""
    ends = np.stack([one.ranges for one in records])
    (near, far), (slow, fast) = zip(ends[:, 0].min(axis=0), ends[:, 1].max(axis=0), strict=True)
    return (float(near), float(far)), (float(slow), float(fast))


def _gusts(found: SearchResult) -> Gusts | None:
    problem = found.problem
    model = problem.model.at(found.unknowns[problem.count :])
    sizes = {one.name: one for one in model.processes}
    if SWAY not in model.gusts:
        return None
    usual = {one.name: one.std for one in problem.model.processes}
    strength = max(sizes[name].std / usual[name] for name in (SWAY, YAW))
    return Gusts(sizes[SWAY].std, sizes[YAW].std, sizes[SWAY].memory, model.correlation, float(strength))


def _noise(found: SearchResult) -> dict[str, SignalNoise]:
    noise = found.problem.model.at(found.unknowns[found.problem.count :]).noise
    counts = {name: np.sum([one.outliers.get(name, (0, 0)) for one in found.records], axis=0) for name in noise}
    return {
        name: SignalNoise(size, float(counts[name][0] / max(counts[name][1], 1)))
        for name, size in noise.items() if name != HELM
    }  # fmt: skip


# Assumptions of a result, one sentence each.
def said_granted(problem: LogProblem, free: Sequence[str], answers: Sequence[RecordAnswer]) -> tuple[str, ...]:
    """Return the notes on fixed coefficients, on ship and water, and on passing ships."""
    return (*_held(free), *_ship_and_water(problem), *_met(sum(answer.met for answer in answers)))


def _held(free: Sequence[str]) -> tuple[str, ...]:
    if not free:
        return ()
    return (f"Only {', '.join(free)} may change. Their intervals include the errors of the fixed coefficients.",)


def _ship_and_water(problem: LogProblem) -> tuple[str, ...]:
    model = problem.motion.model
    if not model.feels_bank:
        return ()
    known = "waterway" in problem.motion.choices
    depth = "the waterway's depths" if known else f"a depth of {model.configuration.canal.depth:.3g} m"
    return (
        f"Assumed: a draft of {model.configuration.ship.draft:.3g} m, {depth}, and charted banks with one offset to "
        "each record. At another depth or draft the coefficients differ, and a transit does not show it. The intervals "
        "are then too narrow.",
    )


def _met(steps: int) -> tuple[str, ...]:
    if not steps:
        return ()
    return (f"Another ship passed in {steps} steps; forces there are not used.",)
