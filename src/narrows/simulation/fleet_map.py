"""Voyages of many ships: an xarray Dataset with a map plot."""

from typing import TYPE_CHECKING, Any

import xarray as xr

import narrows

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from narrows.model.model import Model
    from narrows.waterway.waterway import Waterway


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
