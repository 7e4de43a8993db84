"""Results of a map of voyages: distance to the grounding, its side, and its probability within a distance."""

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

import narrows
from narrows.errors import InputError
from narrows.results.base_results import answer
from narrows.simulation.outcome import Code

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from narrows.model.model import Model
    from narrows.waterway.waterway import Waterway


def grounding_distance(voyages: xr.Dataset) -> xr.DataArray:
    """Return the distance along the canal to the grounding [m], NaN if there is none.

    Parameters
    ----------
    voyages : Dataset
        Result of ``ensemble``.

    Examples
    --------
    >>> float(nw.grounding_distance(nw.ensemble(model, y=[0.5], u=1.0))[0].round(1))
    11.2
    """
    distance = voyages["distance"].where(voyages["outcome"] == Code.GROUNDED)
    return distance.assign_attrs(units="m", long_name="distance to grounding")


def grounding_probability(voyages: xr.Dataset, distance: float, over: str = "sample") -> xr.DataArray:
    """Return the share of samples that ground within a distance [1].

    It is unknown (NaN) if a voyage ended before that distance in another way: its time ran out, it diverged, turned
    across the canal or left the waterway.

    Parameters
    ----------
    voyages : Dataset
        Result of ``ensemble`` with ``samples``.
    distance : float [m]
        Distance along the canal.
    over : str
        The dimension of the samples.

    Raises
    ------
    InputError
        If the voyages have no such dimension.

    Examples
    --------
    >>> fleet = nw.ensemble(kcs, y=[0.0, 60.0], u=6.0, samples=4)
    >>> nw.grounding_probability(fleet, 1000.0).dims
    ('y',)
    """
    if over not in voyages.dims:
        raise InputError(
            f"these voyages have no dimension {over!r}; draw coefficients, as in ensemble(..., samples=200)"
        )
    grounded, far = voyages["outcome"] == Code.GROUNDED, voyages["distance"] > distance
    within = (grounded & ~far).mean(over).where((grounded | far).all(over))
    name = f"probability of grounding within {distance:g} m"
    return within.assign_attrs(units="1", long_name=name)


def map_summary(voyages: xr.Dataset) -> dict[str, Any]:
    outcome, side = voyages["outcome"].to_numpy(), voyages["side"].to_numpy()
    distance = grounding_distance(voyages).to_numpy()
    count = {code.name.lower(): int((outcome == code).sum()) for code in Code}
    sides = {"starboard": int((side > 0).sum()), "port": int((side < 0).sum())}
    near = float(np.nanmin(distance)) if count["grounded"] else None
    where = f"{sides['starboard']} to starboard, {sides['port']} to port"
    sentence = f"{outcome.size} voyages: {count['grounded']} ground ({where})"
    nearest = f", the nearest after {near:.2f} m" if near is not None else ""
    rest = f"; {count['afloat']} are afloat at the end, {count['outside']} turn across the canal"
    left = count["astern"] + count["passed"]
    rest += f", {left} leave the waterway" if left else ""
    diverged = count["diverged"]
    rest += f", {diverged} diverge: shorten the time step or look at the coefficients" if diverged else ""
    notes = str(voyages.attrs.get("notes", "")).splitlines()
    return {
        "voyages": int(outcome.size), "outcomes": count, "sides": sides, "nearest": near,
        "complete": bool(voyages.attrs["complete"]), "notes": notes,
        "summary": " ".join([f"{sentence}{nearest}{rest}.", *notes]),
    }  # fmt: skip


class Fleet(xr.Dataset):  # type: ignore[misc]
    """The result of ``ensemble``: an xarray Dataset whose ``plot()`` draws where the ships ground.

    ``plot.scatter`` and the like are xarray's. A part of it (``isel``, ``where``) is a fleet without its model: its map
    has no title, and all of it is marked as untested.

    Examples
    --------
    >>> fleet = nw.ensemble(model, y=[0.2, 0.5])
    >>> fleet.grounded.values.tolist()
    [True, True]
    """

    __slots__ = ("_model", "_waterway")

    @classmethod
    def of(cls, voyages: xr.Dataset, model: "Model", waterway: "Waterway | None" = None) -> "Fleet":
        """Return voyages as a fleet of a model.

        Parameters
        ----------
        voyages : xarray.Dataset
            One entry per voyage.
        model : Model
            The ship and its tested range.
        waterway : Waterway, optional
            Waterway instead of the model's own canal.
        """
        fleet = cls(voyages.data_vars, coords=voyages.coords, attrs=voyages.attrs)
        fleet._model, fleet._waterway = model, waterway
        return fleet

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            try:
                return super().__getattr__(name)
            except AttributeError:
                if name.startswith("_"):
                    raise
                return answer(self, name, [str(own) for own in self.variables])

    def summary(self) -> str:
        """Return how many ground, on which side, and the nearest, in words."""
        return str(map_summary(self)["summary"])

    def to_xarray(self) -> xr.Dataset:
        """Return the data as a plain Dataset."""
        return xr.Dataset(self.data_vars, self.coords, self.attrs)

    @property
    def plot(self) -> "FleetPlot":
        """Draw the map: ``plot()``, or ``plot(within=500.0)`` for the probability of grounding within 500 m."""
        return FleetPlot(self)


class FleetPlot:
    """The map of a fleet when it is called, xarray's own plots by their names."""

    def __init__(self, fleet: Fleet) -> None:
        self._fleet = fleet

    def __call__(self, within: float | None = None) -> "Figure":
        model, waterway = (getattr(self._fleet, name, None) for name in ("_model", "_waterway"))
        return narrows.report.map_figure(self._fleet, model, within, waterway)

    def __getattr__(self, name: str) -> Any:
        return getattr(super(Fleet, self._fleet).plot, name)
