"""What an answer takes for granted, in sentences that stand among its notes."""

from collections.abc import Sequence

from narrows.logbook.learning.record_answers import RecordAnswer
from narrows.logbook.shooting.log_problem import LogProblem


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
