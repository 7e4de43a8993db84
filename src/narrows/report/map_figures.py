"""Maps of where ships ground, and how likely."""

import textwrap
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from narrows.errors import InputError
from narrows.model.data_range import DataRange
from narrows.model.model import Model
from narrows.quantities.constants import KNOT
from narrows.report.style import BLUE, FONT, GREY, PURPLE, WIDTH, Picture, headed, notes_below
from narrows.report.voyage_figures import SIDES
from narrows.ship.particulars import Configuration
from narrows.simulation.maps import grounding_distance, grounding_probability, map_summary
from narrows.waterway.waterway import Waterway

LABELS = {
    "x": "start along the waterway x(0) [m]",
    "y": "start to starboard of the centreline y(0) [m]",
    "u": "surge velocity u [m/s]",
    "psi": "heading at the start [deg]",
    "width": "canal width W [m]",
}


def map_figure(
    voyages: xr.Dataset, model: Model, within: float | None = None, waterway: Waterway | None = None,
    start: Mapping[str, Any] | None = None,
) -> Figure:  # fmt: skip
    """Draw a map of voyages: distance to grounding over one or two dimensions, or its probability.

    Parameters
    ----------
    voyages : Dataset
        From ``ensemble``.
    model : Model
        Whose ship it is, and what its tests covered.
    within : float [m], optional
        Draw the probability of grounding within this distance, over the samples.
    waterway : Waterway, optional
        Where they were instead of the model's own canal.
    start : mapping of str to number, optional
        What did not vary: u [m/s], psi [rad] and the like, for the title.

    Raises
    ------
    InputError
        Where there are more than two dimensions beside the samples.
    """
    quantity = grounding_distance(voyages) if within is None else grounding_probability(voyages, within)
    if within is None and "sample" in quantity.dims:
        quantity = quantity.median("sample", keep_attrs=True)
        voyages = voyages.isel(sample=0)
    dims = [str(name) for name in quantity.dims]
    if len(dims) not in (1, 2):
        raise InputError(f"a picture has one or two dimensions, and this map has {len(dims)}: {', '.join(dims)}")
    with rc_context(FONT):
        figure = Picture(figsize=(WIDTH, 4.8), layout="constrained")
        axes = figure.subplots()
        keys: list[Any] = []
        if quantity.notnull().any():
            keys = (_line if len(dims) == 1 else _field)(figure, axes, quantity, voyages["side"], within is None)
        else:
            _say_nothing_grounds(axes, quantity, str(map_summary(voyages)["summary"]))
        axes.set_xlabel(LABELS.get(dims[0], dims[0]))
        keys += _mark_tested(axes, quantity, model.data_range)
        axes.legend(handles=keys, frameon=False, loc="upper left", bbox_to_anchor=(0.0, -0.14), ncols=3)
        if dims == ["y"] and within is None and waterway is None:
            _clearance_on_top(axes, model.configuration)
        notes_below(figure, str(voyages.attrs.get("notes", "")).splitlines())
        headed(figure, *_title(model.configuration, waterway, start or {}))
    return figure


def _title(configuration: Configuration, waterway: Waterway | None, start: Mapping[str, Any]) -> tuple[str, list[str]]:
    """The ship at its size, where it is, and what did not vary."""
    where = waterway.name if waterway else configuration.canal.in_words
    parts = [f"{configuration.ship.in_words}, in {where}"]
    held = {name: float(value) for name, value in start.items() if np.ndim(value) == 0}
    if "u" in held:
        parts.append(f"{held['u']:.3g} m/s ({held['u'] / KNOT:.3g} knots)")
    parts += [f"heading {np.degrees(held['psi']):.3g} deg"] if held.get("psi") else []
    parts += [f"rudder {np.degrees(held['rudder']):.3g} deg"] if held.get("rudder") else []
    return parts[0], ["; ".join(parts[1:])]


def _say_nothing_grounds(axes: Axes, quantity: xr.DataArray, sentence: str) -> None:
    """Words in place of an empty plot."""
    at = _scaled(quantity, str(quantity.dims[0]))
    axes.set_xlim(float(at.min()), float(at.max()))
    axes.set_yticks([])
    words = "\n".join(textwrap.wrap(sentence, 60))
    axes.text(0.5, 0.5, words, transform=axes.transAxes, ha="center", va="center")


def _mark_tested(axes: Axes, quantity: xr.DataArray, known: DataRange) -> list[Any]:
    """Hatch where starts or speeds are beyond the tests; return the key to it."""
    tested = {"y": known.abs_y and (-known.abs_y[1], known.abs_y[1]), "u": known.speed}
    marked = False
    for axis, name in enumerate(str(name) for name in quantity.dims):
        if (covered := tested.get(name)) is not None:
            marked |= _hatch_beyond(axes, axis, covered)
    look: dict[str, Any] = {"facecolor": "none", "edgecolor": PURPLE, "hatch": ".."}
    return [Patch(label="not tested: the model's guess", **look)] if marked else []


def _hatch_beyond(axes: Axes, axis: int, covered: tuple[float, float]) -> bool:
    low, high = (axes.get_ylim if axis else axes.get_xlim)()
    bands = [(start, stop) for start, stop in ((low, covered[0]), (covered[1], high)) if start < stop]
    for start, stop in bands:
        (axes.axhspan if axis else axes.axvspan)(start, stop, fc="none", ec=PURPLE, hatch="..", lw=0, zorder=3)
    (axes.set_ylim if axis else axes.set_xlim)(low, high)
    return bool(bands)


def _scaled(quantity: xr.DataArray, name: str) -> np.ndarray:
    values: np.ndarray = quantity[name].to_numpy()
    return np.degrees(values) if name == "psi" else values


def _said(quantity: xr.DataArray) -> str:
    return f"{quantity.attrs['long_name']} [{quantity.attrs['units']}]"


def _line(figure: Figure, axes: Axes, quantity: xr.DataArray, side: xr.DataArray, by_side: bool) -> list[Any]:
    at = _scaled(quantity, str(quantity.dims[0]))
    if by_side:
        for code, (word, colour, marker, _) in SIDES.items():
            chosen = quantity.where(side == code)
            axes.plot(at, chosen, color=colour, marker=marker, markersize=3, linewidth=1, label=f"grounds to {word}")
    else:
        axes.plot(at, quantity, color=BLUE)
    axes.set_ylabel(_said(quantity))
    axes.grid(alpha=0.3)
    return list(axes.get_legend_handles_labels()[0])


def _field(figure: Figure, axes: Axes, quantity: xr.DataArray, side: xr.DataArray, by_side: bool) -> list[Any]:
    across, up = (str(name) for name in quantity.dims)
    x, y = _scaled(quantity, across), _scaled(quantity, up)
    if not by_side:
        mesh = axes.pcolormesh(x, y, quantity.T, cmap="cividis", vmin=0, vmax=1, shading="nearest")
        figure.colorbar(mesh, ax=axes, label=_said(quantity))
    else:
        top = float(np.nanmax(quantity)) if np.isfinite(quantity).any() else 1.0
        for code, (word, _, _, colours) in SIDES.items():
            part = quantity.where(side == code)
            mesh = axes.pcolormesh(x, y, part.T, cmap=colours, vmin=0, vmax=1.2 * top, shading="nearest")
            figure.colorbar(mesh, ax=axes, label=f"to {word}: {_said(quantity)}", pad=0.02)
    axes.set_ylabel(LABELS.get(up, up))
    white = by_side and quantity.isnull().any()
    return [Patch(facecolor="white", edgecolor=GREY, lw=0.6, label="does not ground")] if white else []


def _clearance_on_top(axes: Axes, configuration: Configuration) -> None:
    """The paper's own axis: starboard clearance at the start."""
    edge = (configuration.canal.width - configuration.ship.beam) / 2

    def other_side(value: Any) -> Any:
        return edge - value

    top: Any = axes.secondary_xaxis("top", functions=(other_side, other_side))
    top.set_xlabel("starboard clearance at the start $y_s(0)$ [m]")
