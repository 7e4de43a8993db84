"""What is forecast: chances of contact by who steers, the most likely run, and the rudder that is needed."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from narrows.results import Described
from narrows.warning.settings import CERTAIN_CONTACT_TIME, SHORTEST_CONTACT_TIME

NUMBERS = ("t", "urgency", "curved", "rudder", "rudder_needed", "rudder_limit", "rudder_margin")


@dataclass(frozen=True)
class CaseForecast:
    name: str  # Who steers, from when
    probability: float  # Share of the members that meet a bank, or come to lie across [1]
    soon: float  # Share of them within ``SOON`` [1]
    time: float  # Median time to it of those that do; infinite where none does [s]
    side: str  # To which most of them do; empty where none does


@dataclass(frozen=True)
class LikelyRun:
    """The run of the mean state and the model's own coefficients."""

    contact: float  # When it meets a bank with the rudder as it is; infinite where it does not [s]
    side: str  # Which; empty where none
    last_chance: float  # [s] latest takeover of a pilot that keeps it clear; infinite beyond what is tried
    gone: bool  # Whether not even a pilot who takes over now does


@dataclass(frozen=True, repr=False)
class BankForecast(Described):
    t: float  # When it was made [s]
    cases: dict[str, CaseForecast]  # By who steers
    likely: LikelyRun  # The most likely run
    curved: float  # [s] to contact on a track curved by the yaw rate; infinite beyond 120 s
    rudder: float  # Now [rad]
    rudder_needed: float  # [rad] of the steady course here, by the estimated bank; infinite without one
    rudder_limit: float  # Of the gear [rad]

    @property
    def as_it_is(self) -> CaseForecast:
        """With the rudder as it is. It is no chance of grounding: people act."""
        return self.cases[AS_IS]

    @property
    def pilot_now(self) -> CaseForecast:
        return self.cases[PILOT_NOW]

    @property
    def urgency(self) -> float:
        return float(urgency_of(self.pilot_now.probability, self.likely.contact, self.curved))

    @property
    def side(self) -> str:
        """To which the danger is; empty where there is none."""
        return self.likely.side or self.pilot_now.side or self.as_it_is.side

    @property
    def rudder_margin(self) -> float:
        """Rudder that is left beside what is needed [rad]; negative where there is none."""
        return self.rudder_limit - abs(self.rudder_needed)

    @property
    def notes(self) -> tuple[str, ...]:
        return ("The chance with the rudder as it is says what happens if nobody acts: it is no chance of grounding.",)

    def summary(self) -> str:
        run, now = self.likely, self.pilot_now
        as_is = f"contact to {run.side} in {run.contact:.0f} s" if math.isfinite(run.contact) else "no contact"
        needed = math.degrees(self.rudder_needed)
        held = f"{needed:.0f} of {math.degrees(self.rudder_limit):.0f} degrees" if math.isfinite(needed) else "no angle"
        return (
            f"As the rudder is: {as_is}; last chance {_chance(run)}.\n"
            f"A pilot who takes over now meets a bank in {100 * now.probability:.1f} % of the cases; {held} of rudder "
            "hold it here."
        )

    def words(self) -> str:
        """Say what there is to be alerted of, in few words."""
        run, now = self.likely, self.pilot_now
        bank = f"bank to {self.side}" if self.side else "bank"
        if math.isfinite(run.contact):
            waits = f"{run.last_chance:.0f} s to act" if math.isfinite(run.last_chance) else "a pilot can still wait"
            return f"{run.contact:.0f} s to {bank}, {'last chance gone' if run.gone else waits}"
        if not now.probability and not self.as_it_is.soon:
            return f"No contact within {AFTER:.0f} s, rudder as it is"
        return f"{100 * now.probability:.0f} % {bank} with a pilot now"

    def to_dict(self) -> dict[str, Any]:
        own = {name: getattr(self, name) for name in NUMBERS}
        cases = {name: vars(case) for name, case in self.cases.items()}
        return {"summary": self.summary(), **own, "likely": vars(self.likely), "cases": cases, "notes": [*self.notes]}


def urgency_of(pilot_now: Any, contact: Any, curved: Any) -> Any:
    """Return the urgency [1] from a pilot's chance of contact now and two times to contact [s]."""
    # The curved track knows nothing of the model, and so is not wrong where the model is.
    return pilot_now + sum(CERTAIN_CONTACT_TIME / np.maximum(time, SHORTEST_CONTACT_TIME) for time in (contact, curved))


def _chance(run: LikelyRun) -> str:
    if run.gone:
        return "gone"
    return f"in {run.last_chance:.0f} s" if math.isfinite(run.last_chance) else f"later than {TAKEOVERS[-1]:.0f} s"


# Which futures are forecast: who steers, from when, and for how long it is looked at.
AS_IS = "as it is"
# When a pilot takes over [s].
TAKEOVERS = (0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0)
# The same, for the most likely run alone [s].
CHANCES = tuple(np.arange(0.0, 61.0, 2.0).tolist())
# How long it is looked at from the takeover on [s], or from the start; and with the rudder hard over [s].
AFTER, HARD_OVER_TIME = 120.0, 60.0
NEVER = 1e9
PORT, STARBOARD = -1.0, 1.0


@dataclass(frozen=True)
class Case:
    name: str  # What happens
    taken_over: float  # When a pilot takes over [s]
    duration: float  # How long it is looked at [s]
    hard_over: float = 0.0  # [1] side of the rudder: -1 port, 1 starboard, 0 as it is


def pilot_case(taken_over: float) -> Case:
    when = "now" if taken_over == 0.0 else f"after {taken_over:g} s"
    return Case(f"pilot {when}", taken_over, taken_over + AFTER)


CASES = (
    Case(AS_IS, NEVER, AFTER), *map(pilot_case, TAKEOVERS),
    Case("hard to port", NEVER, HARD_OVER_TIME, PORT), Case("hard to starboard", NEVER, HARD_OVER_TIME, STARBOARD),
)  # fmt: skip

# Those of the most likely run.
LIKELY = (CASES[0], *map(pilot_case, CHANCES), *CASES[-2:])
PILOT_NOW = CASES[1].name
