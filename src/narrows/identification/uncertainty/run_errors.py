"""What differs from run to run: gain, zero and form, as a prior that repeats may correct."""

from dataclasses import dataclass

from narrows.errors import InputError

# Of an error, as a share: a force that is off by itself tells nothing.
MOST = 1.0


@dataclass(frozen=True)
class RunErrors:
    """Errors that all rows of a run share, and that no number of rows averages away.

    The defaults are what the repeats that come with the package scatter by (1.1 to 3.4 % of the first harmonic of
    a force, about 2 %) and, for what no repeat sees, the same again.

    Parameters
    ----------
    gain : float [1]
        Standard deviation of a run's gain: each force is off by this share of itself.
    zero : float [1]
        Standard deviation of a run's zero, over the force's root mean square in all tests.
    form : float [1]
        Standard deviation of what the terms miss of a motion, over the motion's root mean square force, spread
        evenly over the directions that its columns can take; the same in every repeat of it.
    repeats_worth : float [1]
        How many repeats the prior of gain and zero counts for against those that the tests hold.

    Raises
    ------
    InputError
        Where an error is negative, or as large as the force itself.
    """

    gain: float = 0.02
    zero: float = 0.02
    form: float = 0.02
    repeats_worth: float = 4.0

    def __post_init__(self) -> None:
        for name in ("gain", "zero", "form"):
            if not 0 <= getattr(self, name) < MOST:
                raise InputError(
                    f"run errors: {name} = {getattr(self, name)} is no share of a force; give 0.02 for 2 %"
                )
        if not self.repeats_worth > 0:
            raise InputError(f"run errors: repeats_worth = {self.repeats_worth} must be positive; give 4")

    @property
    def none(self) -> bool:
        """Whether runs are said to differ by the noise within them alone."""
        return self.gain == self.zero == self.form == 0


def run_errors_of(written: str) -> RunErrors:
    """Read errors of runs, ``gain,zero,form``."""
    try:
        gain, zero, form = (float(part) for part in written.split(","))
    except ValueError:
        raise InputError(
            f"run errors {written!r} are not understood; give gain,zero,form as in 0.02,0.02,0.02"
        ) from None
    return RunErrors(gain, zero, form)
