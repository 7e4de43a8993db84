"""Where a ship is safe, in a sentence or three that no caveat is left out of."""

import numpy as np
import xarray as xr

from narrows.quantities.constants import KNOT
from narrows.safety.edges import crossing, largest_rectangle

NOWHERE = "At no offset and speed is the ship held in nineteen cases of twenty with the rudder and the keel in reserve."


def headline(data: xr.Dataset, share: float) -> str:
    """Say from where to where it is safe, in what it was not tested, and how well the edge is known (ours).

    The offsets and speeds are those of the largest block of the grid in which every place is safe.

    Parameters
    ----------
    data : xarray.Dataset
        Of a ``SafeEnvelope``.
    share : float [1]
        Of the samples that must be held.
    """
    data = data.transpose("y", "u", ...)
    y, u = data["y"].to_numpy(), data["u"].to_numpy()
    by_model = ((data["held"] >= share) & data["clear"]).to_numpy()
    tested = data["tested"].to_numpy()
    block, section = largest_rectangle(by_model & tested, y, u), data.attrs["untested"]
    guess = [f"Not tested, so what follows is the model's guess: {section}."] if section else []
    if block is None:
        return " ".join([*guess, _nowhere(by_model, y, u)])
    offsets, speeds = _offsets(data, block, share), u[block[1]] / KNOT
    sentences = [*guess, f"Safe {_between(speeds, offsets)}, in nineteen cases of twenty."]
    wider = largest_rectangle(by_model, y, u)
    if wider is not None and wider != block:
        span = _between(u[wider[1]] / KNOT, tuple(y[wider[0]][[0, -1]]))
        sentences.append(f"By the model also {span}, but there the tests end.")
    return " ".join([*sentences, *_doubt(data, share, block)])


def _nowhere(by_model: np.ndarray, y: np.ndarray, u: np.ndarray) -> str:
    wider = largest_rectangle(by_model, y, u)
    if wider is None:
        return NOWHERE
    return f"Nowhere safe within the tests; by the model {_between(u[wider[1]] / KNOT, tuple(y[wider[0]][[0, -1]]))}."


def _between(speeds: np.ndarray, offsets: tuple[float, float]) -> str:
    low, high = float(speeds[0]), float(speeds[-1])
    fast = f"at {low:.1f} knots" if low == high else f"from {low:.1f} to {high:.1f} knots"
    if offsets[0] == offsets[1]:
        return f"{fast} at {offsets[0]:+.1f} m off the middle (starboard is positive)"
    return f"{fast} between {offsets[0]:+.1f} and {offsets[1]:+.1f} m off the middle (starboard is positive)"


def _offsets(data: xr.Dataset, block: tuple[slice, slice], share: float, name: str = "held") -> tuple[float, float]:
    """The outermost offsets at which every speed of a block is held, straight between those of the grid."""
    y, first, last = data["y"].to_numpy(), block[0].start, block[0].stop - 1
    low, high = [], []
    for held in data[name].to_numpy()[:, block[1]].T:
        low.append(crossing(y, held, first, first - 1, share) if first > 0 else float(y[0]))
        high.append(crossing(y, held, last, last + 1, share) if last + 1 < len(y) else float(y[-1]))
    return max(low), min(high)


def _doubt(data: xr.Dataset, share: float, block: tuple[slice, slice]) -> list[str]:
    """How far the number of cases leaves the edges open."""
    y, u, clear = data["y"].to_numpy(), data["u"].to_numpy(), data["clear"].to_numpy() & data["tested"].to_numpy()
    sure, perhaps = (
        largest_rectangle((data[name].to_numpy() >= share) & clear, y, u) for name in ("held_low", "held_high")
    )
    if sure == perhaps or perhaps is None:
        return []
    if sure is None:
        return [f"With {data.attrs['samples']} cases tried this is not certain anywhere; try more."]
    count = f"{data.attrs['samples']} cases were tried: that leaves the edges open"
    return [f"{count}, for certain {_between(u[sure[1]] / KNOT, tuple(y[sure[0]][[0, -1]]))}."]
