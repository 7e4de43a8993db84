"""How a voyage can end."""

from enum import IntEnum


class Outcome(IntEnum):
    """How a voyage ended; each value has its sentence."""

    AFLOAT = 0
    GROUNDED = 1
    DIVERGED = 2
    OUTSIDE = 3

    @property
    def sentence(self) -> str:
        """The outcome in words."""
        return SENTENCES[self]


SENTENCES = {
    Outcome.AFLOAT: "The ship was still afloat when the time was up.",
    Outcome.GROUNDED: "The hull met a bank.",
    Outcome.DIVERGED: "The motion grew beyond any sense; shorten the time step or look at the coefficients.",
    Outcome.OUTSIDE: "The ship turned across the canal, where the model says nothing.",
}
