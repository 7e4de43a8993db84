"""Pictures of voyages: paths in the canal, and maps of where ships ground."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from narrows.errors import InputError
from narrows.files import is_stream, write_whole
from narrows.ship.particulars import Configuration
from narrows.simulation.maps import grounding_distance, grounding_probability
from narrows.simulation.voyage import Voyage
from narrows.waterway.waterway import Waterway

BLUE, ORANGE, GREY = "#0072B2", "#D55E00", "#5A5A5A"
BANK_POINTS = 400
SIDES = {-1: ("port", BLUE, "o", "Blues_r"), 1: ("starboard", ORANGE, "^", "Oranges_r")}
LABELS = {
    "y": "start to starboard of the centreline y(0) [m]",
    "u": "surge velocity u [m/s]",
    "psi": "heading at the start [deg]",
    "width": "canal width W [m]",
}


def save_figure(figure: Figure, path: Path) -> None:
    """Write a picture, whole or not at all.

    Parameters
    ----------
    figure : Figure
        The picture.
    path : Path
        Its suffix says which kind: png, svg or pdf; png into a device without one.

    Raises
    ------
    InputError
        Where the suffix is no kind of picture or the file cannot be written.
    """
    from io import BytesIO

    kind = path.suffix.lower().removeprefix(".") or ("png" if is_stream(path) else "")
    if kind not in ("png", "svg", "pdf"):
        raise InputError(f"{path}: cannot draw a {kind or 'nameless'} picture; name it .png, .svg or .pdf")
    memory = BytesIO()
    figure.savefig(memory, format=kind, dpi=150)
    write_whole(path, memory.getvalue())


def voyage_figure(voyage: Voyage, configuration: Configuration, waterway: Waterway | None = None) -> Figure:
    """Draw one voyage: her path with the hull at intervals, heading and velocities below.

    Parameters
    ----------
    voyage : Voyage
        What to draw.
    configuration : Configuration
        Ship and canal.
    waterway : Waterway, optional
        Where she sailed instead of that canal.
    """
    figure = Figure(figsize=(7.0, 6.0), layout="constrained")
    above, middle, below = figure.subplots(3, 1, height_ratios=[2.2, 1, 1])
    paths_on(above, [voyage], configuration, waterway)
    above.set_title(voyage.outcome.sentence.split(". ")[0].rstrip(".") + ".", fontsize=9, loc="left")
    middle.plot(voyage.t, np.degrees(voyage.psi), color=BLUE, label="heading [deg]")
    middle.plot(voyage.t, np.degrees(voyage.r), color=ORANGE, linestyle="--", label="yaw rate [deg/s]")
    if np.ptp(voyage.rudder) > 0:
        middle.plot(voyage.t, np.degrees(voyage.rudder), color=GREY, linestyle=":", label="rudder [deg]")
    middle.set_ylabel("[deg], [deg/s]")
    below.plot(voyage.t, voyage.u, color=BLUE, label="surge u [m/s]")
    below.plot(voyage.t, voyage.v, color=ORANGE, linestyle="--", label="sway v [m/s]")
    below.set_ylabel("velocity [m/s]")
    below.set_xlabel("time [s]")
    for axes in (middle, below):
        axes.grid(alpha=0.3)
        axes.legend(fontsize=8, frameon=False)
    return figure


def paths_figure(voyages: Sequence[Voyage], configuration: Configuration) -> Figure:
    """Draw several voyages in one canal (the paper's fig. sim).

    Parameters
    ----------
    voyages : sequence of Voyage
        What to draw.
    configuration : Configuration
        Ship and canal.
    """
    figure = Figure(figsize=(7.0, 3.6), layout="constrained")
    paths_on(figure.subplots(), voyages, configuration)
    return figure


def paths_on(
    axes: Axes, voyages: Sequence[Voyage], configuration: Configuration, waterway: Waterway | None = None
) -> None:
    """Draw paths and banks, bow to the right, starboard down (ours).

    Parameters
    ----------
    axes : Axes
        Where.
    voyages : sequence of Voyage
        What to draw.
    configuration : Configuration
        Ship and canal.
    waterway : Waterway, optional
        Where they sailed instead of that canal; its line is drawn straight.
    """
    far = max(float(v.x.max()) for v in voyages) + configuration.ship.length
    near = min(float(v.x.min()) for v in voyages) - configuration.ship.length
    half = _banks_on(axes, near, far, configuration, waterway)
    for voyage in voyages:
        side = {"starboard": 1, "port": -1}.get(voyage.outcome.side or "", 0)
        colour = SIDES[side][1] if side else GREY
        axes.plot(voyage.x, voyage.y, color=colour, linewidth=1.0, linestyle="-" if side < 0 else "--")
        axes.add_patch(hull(voyage, len(voyage.x) - 1, configuration, colour))
    if len(voyages) == 1:
        for i in range(0, len(voyages[0].x) - 1, max(1, len(voyages[0].x) // 6)):
            axes.add_patch(hull(voyages[0], i, configuration, GREY, 0.25))
    axes.set(xlim=(near, far), ylim=(half * 1.12, -half * 1.12), aspect="equal")
    axes.set_xlabel("along the canal x [m]")
    axes.set_ylabel("to starboard y [m]")


def _banks_on(axes: Axes, near: float, far: float, configuration: Configuration, waterway: Waterway | None) -> float:
    """Draw both banks, and return how far off the farther one is."""
    x = np.linspace(near, far, BANK_POINTS)
    half, middle = np.full(BANK_POINTS, configuration.canal.width / 2), np.zeros(BANK_POINTS)
    if waterway is not None:
        room = waterway.room(x, configuration.ship.draft)
        half, middle = room.width / 2, room.middle
    reach = float((half + np.abs(middle)).max())
    for sign in (-1, 1):
        bank = middle + sign * half
        axes.plot(x, bank, color=GREY, linewidth=2)
        axes.fill_between(x, bank, sign * reach * 1.12, color=GREY, alpha=0.35, linewidth=0)
    return reach


def hull(voyage: Voyage, i: int, configuration: Configuration, colour: str, alpha: float = 0.7) -> Polygon:
    """Outline the ship at one row of a voyage (ours).

    Parameters
    ----------
    voyage : Voyage
        Which.
    i : int
        Row.
    configuration : Configuration
        Ship and canal.
    colour : str
        Of the fill.
    alpha : float [1]
        Of the fill.
    """
    length, beam = configuration.ship.length, configuration.ship.beam
    shape = np.array([[-0.5, -0.5], [-0.5, 0.5], [0.35, 0.5], [0.5, 0.0], [0.35, -0.5]]) * [length, beam]
    c, s = math.cos(voyage.psi[i]), math.sin(voyage.psi[i])
    place = shape @ np.array([[c, s], [-s, c]]) + [voyage.x[i], voyage.y[i]]
    return Polygon(place, closed=True, facecolor=colour, edgecolor="black", linewidth=0.6, alpha=alpha)


def distances_figure(
    distances: Mapping[str, xr.DataArray], sides: Mapping[str, xr.DataArray], configuration: Configuration
) -> Figure:
    """Draw the distance to grounding against the clearance at the start, a line a reading (fig. ground_dist).

    Parameters
    ----------
    distances : mapping of str to DataArray [m]
        Over ``y``.
    sides : mapping of str to DataArray
        Where each grounds; thick where to starboard.
    configuration : Configuration
        Ship and canal.
    """
    figure = Figure(figsize=(7.2, 3.8), layout="constrained")
    axes = figure.subplots()
    edge = (configuration.canal.width - configuration.ship.beam) / 2
    for i, (name, distance) in enumerate(distances.items()):
        clearance, colour = edge - distance["y"], (BLUE, ORANGE, "#009E73", "#CC79A7")[i % 4]
        axes.plot(clearance, distance, color=colour, linestyle=("-", "--", "-.", ":")[i % 4], label=name)
        axes.plot(clearance, distance.where(sides[name] > 0), color=colour, linewidth=4, alpha=0.5)
    axes.set_xlabel("starboard clearance at the start $y_s(0)$ [m]; thick: grounds to starboard")
    axes.set_ylabel("distance to grounding [m]")
    axes.grid(alpha=0.3)
    axes.legend(frameon=False)
    return figure


def map_figure(voyages: xr.Dataset, configuration: Configuration, within: float | None = None) -> Figure:
    """Draw a map of voyages: distance to grounding over one or two dimensions, or its probability.

    Parameters
    ----------
    voyages : Dataset
        From ``ensemble``.
    configuration : Configuration
        Ship and canal.
    within : float [m], optional
        Draw the probability of grounding within this distance, over the samples.

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
    figure = Figure(figsize=(7.0, 4.4), layout="constrained")
    axes = figure.subplots()
    (_line if len(dims) == 1 else _field)(figure, axes, quantity, voyages["side"], within is None)
    axes.set_xlabel(LABELS.get(dims[0], dims[0]))
    if dims == ["y"] and within is None:
        _clearance_on_top(axes, configuration)
    return figure


def _scaled(quantity: xr.DataArray, name: str) -> np.ndarray:
    values: np.ndarray = quantity[name].to_numpy()
    return np.degrees(values) if name == "psi" else values


def _said(quantity: xr.DataArray) -> str:
    return f"{quantity.attrs['long_name']} [{quantity.attrs['units']}]"


def _line(figure: Figure, axes: Axes, quantity: xr.DataArray, side: xr.DataArray, by_side: bool) -> None:
    at = _scaled(quantity, str(quantity.dims[0]))
    if by_side:
        for code, (word, colour, marker, _) in SIDES.items():
            chosen = quantity.where(side == code)
            axes.plot(at, chosen, color=colour, marker=marker, markersize=3, linewidth=1, label=f"grounds to {word}")
        axes.legend(frameon=False)
    else:
        axes.plot(at, quantity, color=BLUE)
    axes.set_ylabel(_said(quantity))
    axes.grid(alpha=0.3)


def _field(figure: Figure, axes: Axes, quantity: xr.DataArray, side: xr.DataArray, by_side: bool) -> None:
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
        axes.contour(x, y, side.T, levels=[0.0], colors="black", linewidths=0.8)
    axes.set_ylabel(LABELS.get(up, up))


def _clearance_on_top(axes: Axes, configuration: Configuration) -> None:
    """The paper's own axis: starboard clearance at the start."""
    edge = (configuration.canal.width - configuration.ship.beam) / 2

    def other_side(value: Any) -> Any:
        return edge - value

    top: Any = axes.secondary_xaxis("top", functions=(other_side, other_side))
    top.set_xlabel("starboard clearance at the start $y_s(0)$ [m]")
