"""What a ship's own records hold: one quantity at its own times, under names that are written once."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from narrows.errors import InputError, did_you_mean
from narrows.quantities.names import Quantity

MEETING = "meeting"
# Every signal: its unit and meaning.
SIGNALS = {
    "x": Quantity("m", "antenna or reference point along the waterway, or along the axis that psi is measured from"),
    "y": Quantity("m", "antenna or reference point to starboard of the centreline, or of that axis"),
    "psi": Quantity("rad", "heading from that axis or from the waterway's line, positive to starboard, without jumps"),
    "r": Quantity("rad/s", "yaw rate, positive to starboard"),
    "u": Quantity("m/s", "surge velocity through the water"),
    "v": Quantity("m/s", "sway velocity through the water, positive to starboard"),
    "u_ground": Quantity("m/s", "velocity over ground along the ship"),
    "v_ground": Quantity("m/s", "velocity over ground across the ship, positive to starboard"),
    "speed_over_ground": Quantity("m/s", "speed over ground"),
    "course": Quantity("rad", "course over ground, measured as psi is"),
    "rudder": Quantity("rad", "rudder angle, positive where it turns the bow to starboard"),
    "revolutions": Quantity("1/s", "propeller revolutions n"),
    MEETING: Quantity("1", "1 while another ship passes, else 0: what it pushes is no gust"),
    "wind_speed": Quantity("m/s", "speed of the wind over ground"),
    "wind_direction": Quantity("rad", "where the wind comes from, measured as psi is"),
}
# Directions: a whole turn more is the same.
TURNING = ("psi", "course", "wind_direction")


def check_signals(names: Iterable[str]) -> None:
    """Raise where a name is no signal's."""
    for name in names:
        if name not in SIGNALS:
            raise InputError(f"there is no signal {name!r}{did_you_mean(str(name), SIGNALS)}")


@dataclass(frozen=True, eq=False)
class Signal:
    """One measured quantity at its own times.

    Times stand as they came: uneven, with gaps where nothing came; ``check_log`` says where they go back.

    Parameters
    ----------
    t : array (n,) [s]
        When.
    values : array (n,)
        In the unit of ``SIGNALS``.

    Raises
    ------
    InputError
        Where the two are not of one length, or a number is not finite.
    """

    t: np.ndarray
    values: np.ndarray

    def __post_init__(self) -> None:
        if np.ndim(self.t) != 1 or np.shape(self.t) != np.shape(self.values):
            raise InputError(
                f"a signal with {np.size(self.t)} times and {np.size(self.values)} values; give a value for each time"
            )
        if not (np.isfinite(self.t).all() and np.isfinite(self.values).all()):
            raise InputError("a signal holds what is not finite; leave out the times at which nothing was measured")

    def __len__(self) -> int:
        """How many values."""
        return len(self.t)

    @property
    def step(self) -> float:
        """Usual time between two values [s]; infinite where there are fewer than two."""
        return float(np.median(np.diff(self.t))) if len(self.t) > 1 else np.inf

    def between(self, start: float, stop: float) -> "Signal":
        """Return the part from one time to another, both included.

        Parameters
        ----------
        start, stop : float [s]
            From when to when.
        """
        kept = (self.t >= start) & (self.t <= stop)
        return Signal(self.t[kept], self.values[kept])

    def at(self, t: np.ndarray, longest: float = np.inf) -> np.ndarray:
        """Interpolate between the values, straight; NaN before the first, after the last and in gaps.

        Parameters
        ----------
        t : array (times,) [s]
            When; the signal's own times must rise.
        longest : float [s]
            Between two values, over which they are still joined.
        """
        if not len(self.t):
            return np.full(np.shape(t), np.nan)
        values = np.interp(t, self.t, self.values, left=np.nan, right=np.nan)
        after = np.clip(np.searchsorted(self.t, t), 1, max(len(self.t) - 1, 1))
        wide = np.diff(self.t, append=self.t[-1])[after - 1] > longest
        return np.where(wide & ~np.isin(t, self.t), np.nan, values)
