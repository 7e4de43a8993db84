"""What a map of voyages says: how far to the grounding, on which side, and how likely within a distance."""

from typing import Any

import numpy as np
import xarray as xr

from narrows.compile import Outcome as Code
from narrows.errors import InputError


def grounding_distance(voyages: xr.Dataset) -> xr.DataArray:
    """Return the distance along the canal to the grounding [m], NaN where there is none.

    Parameters
    ----------
    voyages : Dataset
        From ``ensemble``.
    """
    found = voyages["distance"].where(voyages["outcome"] == Code.GROUNDED)
    return found.assign_attrs(units="m", long_name="distance to grounding")


def grounding_probability(voyages: xr.Dataset, distance: float, over: str = "sample") -> xr.DataArray:
    """Return the share of samples that ground within a distance [1].

    Parameters
    ----------
    voyages : Dataset
        From ``ensemble`` with ``samples``.
    distance : float [m]
        Along the canal.
    over : str
        The dimension of the samples.

    Raises
    ------
    InputError
        Where the voyages have no such dimension.
    """
    if over not in voyages.dims:
        raise InputError(f"these voyages have no dimension {over!r}; draw some, as in ensemble(..., samples=200)")
    within = (voyages["outcome"] == Code.GROUNDED) & (voyages["distance"] <= distance)
    name = f"probability of grounding within {distance:g} m"
    return within.mean(over).assign_attrs(units="1", long_name=name)


def map_summary(voyages: xr.Dataset) -> dict[str, Any]:
    """Say in numbers and one sentence what a map holds (ours).

    Parameters
    ----------
    voyages : Dataset
        From ``ensemble``.
    """
    outcome, side = voyages["outcome"].to_numpy(), voyages["side"].to_numpy()
    distance = grounding_distance(voyages).to_numpy()
    count = {code.name.lower(): int((outcome == code).sum()) for code in Code}
    sides = {"starboard": int((side > 0).sum()), "port": int((side < 0).sum())}
    near = float(np.nanmin(distance)) if count["grounded"] else None
    where = f"{sides['starboard']} to starboard, {sides['port']} to port"
    said = f"{outcome.size} voyages: {count['grounded']} ground ({where})"
    nearest = f", the nearest after {near:.2f} m" if near is not None else ""
    rest = f"; {count['afloat']} are afloat at the end, {count['outside']} turn across the canal"
    rest += (
        f", {count['diverged']} diverge: shorten the time step or look at the coefficients" if count["diverged"] else ""
    )
    return {
        "voyages": int(outcome.size), "outcomes": count, "sides": sides, "nearest": near,
        "complete": bool(voyages.attrs["complete"]), "summary": f"{said}{nearest}{rest}.", "notes": [],
    }  # fmt: skip
