"""From a search that is done to its answer."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from narrows.logbook.learned_coefficient import learned_coefficients, learned_model
from narrows.logbook.learning.log_fit import Gusts, LogFit
from narrows.logbook.learning.log_posterior import log_posterior, said_alike
from narrows.logbook.learning.log_source import LogSource
from narrows.logbook.learning.posed_log import GridSource
from narrows.logbook.learning.record_answers import RecordAnswer, record_answers
from narrows.logbook.learning.refined_search import Refined
from narrows.logbook.shooting.log_problem import LogProblem
from narrows.logbook.shooting.push_chain import SWAY, YAW
from narrows.model.data_range import Range
from narrows.model.model import Model
from narrows.terms.term import TermKind


def log_result(
    model: Model, before: np.ndarray, refined: Refined, source: GridSource, log: LogSource, free: Sequence[str]
) -> LogFit:  # fmt: skip
    """Return the answer of a search."""
    # before (n, n)
    found, prior = refined.found, replace(model, covariance=before)
    after = log_posterior(model, before, refined.problem.prior, found, refined.gust_doubt)
    learned = learned_coefficients(prior, after.values, after.covariance)
    answers = record_answers(refined, source)
    came = learned_model(prior, learned, after.covariance, "", *_ranges(refined))
    stopped = (f"Interrupted: {len(found.told)} of {len(refined.states)} records were looked at.",)
    alike = said_alike(refined.problem.prior.names, after.alike)
    about = (*alike, *said_granted(refined.problem, free, answers), *source.left_out, *stopped * found.interrupted)
    return LogFit(
        replace(came, source=log.after(prior, len(answers))), prior, learned, answers,
        _gusts(refined), refined.left, after.disagreement, after.freedom, after.probability,
        after.widened, _inertia(model, refined), about, found.settled,
    )  # fmt: skip


def _inertia(model: Model, refined: Refined) -> tuple[str, ...]:
    """Coefficients of the inertia that the motion feels, one for each that are tied."""
    seconds = {second for _, second in model.terms.ties}
    surge = refined.problem.motion.march.ship.surge
    felt = [term for force, terms in model.terms.forces.items() if force != "X" or surge == "free" for term in terms]
    return tuple(term.name for term in felt if term.kind == TermKind.INERTIA and term.name not in seconds)


def _ranges(refined: Refined) -> tuple[Range, Range]:
    """Distances off the middle, and speeds."""
    starts = np.concatenate([told.own.starts for told in refined.found.told])
    offsets, speeds = np.abs(starts[:, 1]), np.abs(starts[:, 3])
    return (float(offsets.min()), float(offsets.max())), (float(speeds.min()), float(speeds.max()))


def _gusts(refined: Refined) -> Gusts | None:
    chain = refined.problem.chain
    if SWAY not in chain.names:
        return None
    sway, yaw = chain.names.index(SWAY), chain.names.index(YAW)
    strength = float((chain.std / refined.usual.std)[[sway, yaw]].max())
    return Gusts(
        float(chain.std[sway]), float(chain.std[yaw]), float(chain.memory[sway]), float(chain.correlation), strength
    )


# What an answer takes for granted, in sentences that stand among its notes.
def said_granted(problem: LogProblem, free: Sequence[str], answers: Sequence[RecordAnswer]) -> tuple[str, ...]:
    """Return what is said of what was held, of ship and water as they were taken, and of ships that passed."""
    return (*_held(free), *_ship_and_water(problem), *_met(sum(answer.met for answer in answers)))


def _held(free: Sequence[str]) -> tuple[str, ...]:
    if not free:
        return ()
    return (
        f"Only {', '.join(free)} might move; where the others err, the log disagrees with what was known, and the "
        "intervals are the wider for it.",
    )


def _ship_and_water(problem: LogProblem) -> tuple[str, ...]:
    model = problem.motion.model
    if not model.feels_bank:
        return ()
    known = "waterway" in problem.motion.choices
    depth = "the waterway's depths" if known else f"a depth of {model.configuration.canal.depth:.3g} m"
    return (
        f"Taken for granted: a draft of {model.configuration.ship.draft:.3g} m, {depth}, banks where they are charted "
        "but for a zero. In other water, or at another draft, a ship has other coefficients, which a transit does not "
        "tell from these: intervals then hold less often than they say.",
    )


def _met(windows: int) -> tuple[str, ...]:
    if not windows:
        return ()
    return (
        f"In {windows} windows another ship passed. What she pushed is left open, but not how it came and went "
        "within a window: intervals hold somewhat less often than they say.",
    )
