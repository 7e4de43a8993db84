"""Where a ship is safe, in a sentence or three that no caveat is left out of."""

import numpy as np
import xarray as xr

from narrows.quantities.constants import KNOT
from narrows.safety.causes import AT_LENGTH, RANGE, cause
from narrows.safety.edges import crossing, largest_rectangle

NOWHERE = (
    "At no offset and speed does a pilot who does not know the ship hold it in nineteen cases of twenty, with rudder "
    "and keel in reserve"
)


def headline(data: xr.Dataset, share: float) -> str:
    """Say from where to where it is safe, what ends that, and how well the edge is known."""
    # The offsets and speeds are those of the largest block of the grid in which every place is safe. First comes in
    # what the section was not tested; with what is safe, where a pilot who knew the ship would hold it.
    data = data.transpose("y", "u", ...)
    y, u = data["y"].to_numpy(), data["u"].to_numpy()
    by_model = ((data["held"] >= share) & data["clear"]).to_numpy()
    block, section = largest_rectangle(by_model & data["tested"].to_numpy(), y, u), data.attrs["untested"]
    guess = [f"Not tested, so what follows is the model's guess: {section}."] if section else []
    if block is None:
        return " ".join([*guess, _nowhere(data, by_model), *_known(data, share, None), _way(data, share)])
    offsets, speeds = _offsets(data, block, share), u[block[1]] / KNOT
    sentences = [*guess, f"Safe {_between(speeds, offsets)}, in nineteen cases of twenty.", _limits(data, share, block)]
    wider = largest_rectangle(by_model, y, u)
    if wider is not None and wider != block:
        span = _between(u[wider[1]] / KNOT, tuple(y[wider[0]][[0, -1]]))
        sentences.append(f"By the model also {span}, but there the tests end.")
    return " ".join([*sentences, *_known(data, share, block), *_doubt(data, share, block)])


def _nowhere(data: xr.Dataset, by_model: np.ndarray) -> str:
    y, u = data["y"].to_numpy(), data["u"].to_numpy()
    wider = largest_rectangle(by_model, y, u)
    if wider is not None:
        span = _between(u[wider[1]] / KNOT, tuple(y[wider[0]][[0, -1]]))
        return f"Nowhere safe within the tests; by the model {span}."
    best = _best(data)
    if best is None:
        return f"{NOWHERE}."
    place = f"{float(best['y']):+.1f} m and {float(best['u']) / KNOT:.1f} knots"
    return f"{NOWHERE}: at best in {100 * float(best['held']):.0f} of a hundred, at {place}."


def _best(data: xr.Dataset) -> xr.Dataset | None:
    """The place where most cases are held, of those that keel, canal and engine allow."""
    held = data["held"].where(data["clear"], -1.0).transpose("y", "u").to_numpy()
    place = np.unravel_index(held.argmax(), held.shape)
    return None if held[place] < 0 else data.isel(y=int(place[0]), u=int(place[1]))


def _way(data: xr.Dataset, share: float) -> str:
    """What is in the way where nowhere is safe, at the best place."""
    best = _best(data)
    here = data.isel(y=len(data["y"]) // 2, u=0) if best is None else best
    return f"The limit is {AT_LENGTH[cause(here, share, _reserved(data))]}."


def _reserved(data: xr.Dataset) -> float:
    return float((1 - data.attrs["reserve"]) * data.attrs["rudder_limit"])


def _limits(data: xr.Dataset, share: float, block: tuple[slice, slice]) -> str:
    """What ends a block to the sides, and in speed."""
    rows, columns = block
    middle_row, middle_column = (rows.start + rows.stop - 1) // 2, (columns.start + columns.stop - 1) // 2
    aside = rows.stop if rows.stop < len(data["y"]) else rows.start - 1
    sides = "what was asked"
    if aside >= 0:
        sides = AT_LENGTH[cause(data.isel(y=aside, u=middle_column), share, _reserved(data))]
    up = AT_LENGTH[RANGE]
    if columns.stop < len(data["u"]):
        up = AT_LENGTH[cause(data.isel(y=middle_row, u=columns.stop), share, _reserved(data))]
    return f"The limit to the sides is {sides}; in speed, {up}."


def _known(data: xr.Dataset, share: float, block: tuple[slice, slice] | None) -> list[str]:
    """Where a pilot who knew the ship would hold it, where that is elsewhere than what is safe."""
    if bool((data["known"] == data["held"]).all()):
        return []
    allowed = (data["tested"] & data["clear"]).to_numpy()
    y, u = data["y"].to_numpy(), data["u"].to_numpy()
    known = largest_rectangle((data["known"] >= share).to_numpy() & allowed, y, u)
    if known is None:
        return ["Nor would one who knew its coefficients."]
    if known == block:
        return []
    span = _between(u[known[1]] / KNOT, _offsets(data, known, share, "known"))
    return [f"A pilot who knew its coefficients would hold it {span}."]


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
