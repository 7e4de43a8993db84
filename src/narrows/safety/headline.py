"""Summary of where a ship is safe, in one to three sentences with all caveats."""

import math

import numpy as np
import xarray as xr

from narrows.quantities.names import KNOT

# Offsets and speeds of a grid.
Block = tuple[slice, slice]
# Share of cases [1] from which a ship is more likely held than not.
LIKELY = 0.5
# Remedy for an edge that the number of samples leaves uncertain.
MORE = "more samples (--samples, in Python samples=) make it certain"
# Difference of two offsets that are the same in words [m].
SAME_OFFSET = 0.05


def headline(data: xr.Dataset, share: float) -> tuple[list[str], list[str]]:
    """Return the sentences of the answer, and those of its limits."""
    # The answer is the largest block of the grid in which every place is safe, after the untested quantities of the
    # section. The limits include where a pilot with the true coefficients would hold the ship.
    data = data.transpose("y", "u", ...)
    by_model = safe_by(data, share)
    safe, section = by_model & data["tested"].to_numpy(), data.attrs["untested"]
    block, wider = largest_block(data, safe), largest_block(data, by_model)
    # The first sentence of an estimated model names it as one.
    answer = estimated(data)
    answer += [f"Extrapolated, as the tests did not cover this: {section}."] if section else []
    if block is None:
        words, limit = _nowhere(data, share)
        if wider is not None:
            words = f"Nowhere safe within the tests; by the model {_at_places(data, wider)}."
        return [*answer, words], [*_with_true_coefficients(data, share, None), limit]
    word = "Safe by the model" if section else "Safe"  # The chart hatches a section that was not tested, too
    span = place_in_words(data, block[1], safe_offsets(data, block, share))
    limits = [_limits_of(data, share, block)]
    if wider is not None and wider != block:
        limits.append(f"By the model also {_at_places(data, wider)}, but there the tests end.")
    return [*answer, f"{word} {span}, with 95 % probability."], [
        *limits, *_with_true_coefficients(data, share, block), *_sampling_doubt(data, share),
    ]  # fmt: skip


def estimated(data: xr.Dataset) -> list[str]:
    estimate = data.attrs.get("estimate", "")
    return [f"{estimate.partition('. ')[0].removesuffix('.')}."] if estimate else []


def _at_places(data: xr.Dataset, block: Block) -> str:
    return place_in_words(data, block[1], tuple(data["y"].to_numpy()[block[0]][[0, -1]]))


def _nowhere(data: xr.Dataset, share: float) -> tuple[str, str]:
    """Return where most cases are held, and the limit there."""
    nowhere = "No offset and speed is safe with 95 % probability"
    if not data["clear"].any():
        return f"{nowhere}.", f"The limit is {_cause_at_length(data.isel(y=len(data['y']) // 2, u=0), share)}."
    best = data.isel(data["held"].where(data["clear"]).argmax(["y", "u"]))
    # Rounded down, so that a share below a limit does not read as the limit.
    most = math.floor(round(1000 * float(best["held"]), 6)) / 10
    place = f"{float(best['y']):+.1f} m and {float(best['u']) / KNOT:.1f} knots"
    answer = f"{nowhere}: at best {most:g} % of the cases are held, at {place}"
    likely = largest_block(data, safe_by(data, LIKELY))
    if likely is not None:
        answer += f"; more likely held than not {place_in_words(data, likely[1], safe_offsets(data, likely, LIKELY))}"
    return f"{answer}.", f"The limit is {_cause_at_length(best, share)}."


def _limits_of(data: xr.Dataset, share: float, block: Block) -> str:
    rows, columns = block
    aside = rows.stop if rows.stop < len(data["y"]) else rows.start - 1
    sides = _first_limit(data.isel(y=[aside], u=columns), share) if aside >= 0 else AT_LENGTH[RANGE]
    faster = columns.stop < len(data["u"])
    up = _first_limit(data.isel(y=rows, u=[columns.stop]), share) if faster else AT_LENGTH[RANGE]
    return f"The limit to the sides is {sides}; in speed, {up}."


def _first_limit(beside: xr.Dataset, share: float) -> str:
    """Return the cause at the unsafe place nearest the middle, of the places next to the safe block."""
    places = beside.stack(place=("u", "y"))
    safe = ((places["held"] >= share) & places["clear"] & places["tested"]).to_numpy()
    first = int(np.where(safe, math.inf, np.abs(places["y"].to_numpy())).argmin())
    return _cause_at_length(places.isel(place=first), share)


def _cause_at_length(here: xr.Dataset, share: float) -> str:
    return AT_LENGTH[cause(here, share, float((1 - here.attrs["reserve"]) * here.attrs["rudder_limit"]))]


def _with_true_coefficients(data: xr.Dataset, share: float, block: Block | None) -> list[str]:
    """Return where a pilot with the true coefficients would hold the ship, if that differs from the safe block."""
    if bool((data["known"] == data["held"]).all()):
        return []
    by_true = safe_by(data, share, "known")
    known = largest_block(data, by_true & data["tested"].to_numpy())
    if known is None:  # Held, but only outside the tests: the tested range is the limit.
        return [] if by_true.any() else ["A pilot with the true coefficients would not control the ship either."]
    span = place_in_words(data, known[1], safe_offsets(data, known, share, "known"))
    return [f"A pilot with the true coefficients would control the ship {span}."] * (known != block)


def place_in_words(data: xr.Dataset, columns: slice, offsets: tuple[float, float]) -> str:
    """Return speeds and offsets in words; a range that begins at the slowest speed of the grid has no lower limit."""
    speeds = data["u"].to_numpy()[columns] / KNOT
    low, high = float(speeds[0]), float(speeds[-1])
    fast = f"from {low:.1f} to {high:.1f} knots"
    if low == high:
        fast = f"at {low:.1f} knots"
    elif columns.start == 0:
        fast = f"up to {high:.1f} knots (slowest tried {low:.1f})"
    port, starboard = map(float, offsets)
    if abs(port + starboard) < SAME_OFFSET:
        return f"{fast} within {starboard:.1f} m of the middle" if starboard > port else f"{fast} in the middle"
    if port < 0 < starboard:
        return f"{fast}, from {-port:.1f} m to port to {starboard:.1f} m to starboard of the middle"
    near, far = sorted((abs(port), abs(starboard)))
    side = "starboard" if starboard > 0 else "port"
    return f"{fast}, {f'{near:.1f} to ' * (near < far)}{far:.1f} m to {side} of the middle"


def safe_offsets(data: xr.Dataset, block: Block, share: float, name: str = "held") -> tuple[float, float]:
    """The outermost offsets at which every speed of a block is held, linear between those of the grid."""
    y, first, last = data["y"].to_numpy(), block[0].start, block[0].stop - 1
    low, high = [], []
    for held in data[name].to_numpy()[:, block[1]].T:
        low.append(crossing(y, held, first, first - 1, share) if first > 0 else float(y[0]))
        high.append(crossing(y, held, last, last + 1, share) if last + 1 < len(y) else float(y[-1]))
    return max(low), min(high)


def _sampling_doubt(data: xr.Dataset, share: float) -> list[str]:
    tested = data["tested"].to_numpy()
    sure, perhaps = (largest_block(data, safe_by(data, share, name) & tested) for name in ("held_low", "held_high"))
    if sure == perhaps or perhaps is None:
        return []
    if sure is None:
        return [f"With {data.attrs['samples']} cases this is uncertain everywhere; {MORE}."]
    return [f"Certain with {data.attrs['samples']} cases: {_at_places(data, sure)}."]


# Limits of the safe range, in words.
CHOKED, AGROUND = "the canal chokes", "the keel"
NONE, RUDDER, UPSET = "no rudder holds it", "the rudder", "the disturbance"
KNOWLEDGE, PILOT, TESTS, RANGE = "uncertain coefficients", "the pilot", "the tests end", "no faster speed tried"
AT_LENGTH = {
    CHOKED: "the choking of the canal",
    AGROUND: "the water under the keel",
    NONE: "too little rudder",
    RUDDER: "the reserve of rudder",
    UPSET: "the disturbance, which not even a pilot with the true coefficients corrects",
    KNOWLEDGE: "the uncertainty of the coefficients (with the best estimate the ship would be controllable)",
    PILOT: "the pilot (one with the true coefficients would control the ship)",
    TESTS: "the tested range",
    RANGE: "the range that was tried",
}


def cause(here: xr.Dataset, share: float, limit: float) -> str:
    if not bool(here["clear"]):
        return CHOKED if math.isnan(float(here["clearance"])) else AGROUND
    if float(here["held"]) >= share:
        return TESTS
    if float(here["known"]) >= share:
        return PILOT
    if float(here["certain"]) >= share:
        return KNOWLEDGE
    rudder = float(here["rudder_likely"])
    if math.isnan(rudder):
        return NONE
    return RUDDER if abs(rudder) > limit else UPSET


def safe_by(data: xr.Dataset, share: float, name: str = "held") -> np.ndarray:
    """Return where a share of the cases is reached and keel and canal allow it, (offsets, speeds)."""
    return np.asarray(((data[name] >= share) & data["clear"]).transpose("y", "u").to_numpy())


def largest_block(data: xr.Dataset, safe: np.ndarray) -> Block | None:
    """Return the offsets and speeds of the largest block in which everything is safe; None if there is none."""
    y, u = data["y"].to_numpy(), data["u"].to_numpy()
    widths, heights = (np.gradient(values) if len(values) > 1 else np.ones(1) for values in (y, u))
    area, block = 0.0, None
    for first in range(len(y)):
        held = np.ones(len(u), bool)
        for last in range(first, len(y)):
            held &= safe[last]
            for low, up in runs(held):
                covered = float(widths[first : last + 1].sum() * heights[low : up + 1].sum())
                if covered > area:
                    area, block = covered, (slice(first, last + 1), slice(low, up + 1))
    return block


def runs(held: np.ndarray) -> list[tuple[int, int]]:
    """Return the first and the last index of each run of true values."""
    ends = np.flatnonzero(np.diff(np.concatenate([[False], held, [False]]).astype(int)))
    return [(int(a), int(b) - 1) for a, b in zip(ends[::2], ends[1::2], strict=True)]


def crossing(y: np.ndarray, share: np.ndarray, inside: int, outside: int, least: float) -> float:
    """Return the offset between two places where a share falls to its least, by linear interpolation."""
    # y (n,) [m]; share (n,)
    if share[outside] >= least:
        return float(y[inside])
    part = (share[inside] - least) / (share[inside] - share[outside])
    return float(y[inside] + part * (y[outside] - y[inside]))
