"""What a map of voyages says: how far to the grounding, on which side, and how likely within a distance."""

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


def grounding_probability(voyages: xr.Dataset, distance: float, over: str = "draw") -> xr.DataArray:
    """Return the share of draws that ground within a distance [1].

    Parameters
    ----------
    voyages : Dataset
        From ``ensemble`` with ``draws``.
    distance : float [m]
        Along the canal.
    over : str
        The dimension of the draws.

    Raises
    ------
    InputError
        Where the voyages have no such dimension.
    """
    if over not in voyages.dims:
        raise InputError(f"these voyages have no dimension {over!r}; draw coefficients, as in ensemble(..., draws=200)")
    within = (voyages["outcome"] == Code.GROUNDED) & (voyages["distance"] <= distance)
    name = f"probability of grounding within {distance:g} m"
    return within.mean(over).assign_attrs(units="1", long_name=name)
