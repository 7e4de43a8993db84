"""Prior scales of the variance components: errors of runs, of campaigns and of hull terms."""

from dataclasses import dataclass, fields

from narrows.errors import InputError

# As a share of the force: an error as large as the force itself leaves nothing to identify.
LARGEST_RUN_ERROR = 1.0


@dataclass(frozen=True)
class RunErrors:
    """Prior scales of the errors that rows share; the tests then determine the size of each.

    Each is the scale of a half-t prior, which admits larger errors. The defaults of gain, zero and form are the scatter
    of repeats in the bundled KCS tests (1.1 to 3.4 % of a force).

    Parameters
    ----------
    gain : float [1]
        Gain of a run: each force is off by this share of itself.
    zero : float [1]
        Zero of a run, over the force's root mean square in all tests.
    form : float [1]
        Model error of a motion, over the motion's own force; the same in every repeat of it.
    scatter : float [1]
        Scatter from run to run in any direction, over the force's root mean square in all tests.
    hull : float [1]
        Multiplies the usual sizes of what changes hull terms: speed, period, depth, straight runs, walls.
    bank : float [1]
        Multiplies the usual sizes of what changes the bank's term: its form, sides and speeds. These are assumed, like
        those of straight runs against harmonic ones. Fits of the KCS and Lataire tests nearly return their priors.
    campaign : float [1]
        Multiplies the usual sizes of errors that runs share: forces, headings and rudder angles that go with y, rail,
        clock, gauges. The sizes themselves are listed in ``docs/uncertainty.md``.

    Raises
    ------
    InputError
        Where a size is negative, or as large as the force itself.
    """

    gain: float = 0.02
    zero: float = 0.02
    form: float = 0.02
    scatter: float = 0.003
    hull: float = 1.0
    bank: float = 1.0
    campaign: float = 1.0

    def __post_init__(self) -> None:
        for name in ("gain", "zero", "form", "scatter"):
            if not 0 <= getattr(self, name) < LARGEST_RUN_ERROR:
                raise InputError(
                    f"run errors: {name} = {getattr(self, name)} is no share of a force; give 0.02 for 2 %"
                )
        for name in ("hull", "bank", "campaign"):
            if not getattr(self, name) >= 0:
                raise InputError(f"run errors: {name} = {getattr(self, name)} must not be negative; give 1")

    @property
    def none(self) -> bool:
        """Whether runs are assumed to differ only by the noise within them."""
        return self.gain == self.zero == self.form == 0


def run_errors_of(written: str) -> RunErrors:
    """Read errors of runs, ``gain,zero,form`` and, if wished, ``scatter,hull,bank,campaign``."""
    parts = written.split(",")
    names = [entry.name for entry in fields(RunErrors)]
    try:
        if not 3 <= len(parts) <= len(names):
            raise ValueError
        return RunErrors(**dict(zip(names, map(float, parts), strict=False)))
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        raise InputError(
            f"run errors {written!r} are not understood; give gain,zero,form as in 0.02,0.02,0.02"
        ) from None
