"""Figures of voyages: paths in the canal, an animation, and maps of groundings."""

import math
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import xarray as xr
from matplotlib import rc_context
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Polygon

from narrows.base.errors import InputError, shown
from narrows.base.files import form_of, write_whole
from narrows.model.data_range import DataRange
from narrows.model.model import Model
from narrows.quantities.names import KNOT
from narrows.report.style import (
    BLUE,
    DASHES,
    FONT,
    GREY,
    ORANGE,
    PURPLE,
    WIDTH,
    Picture,
    given_axes,
    headed,
    notes_below,
    panels,
    titled,
)
from narrows.ship.particulars import Configuration
from narrows.simulation.ensemble import grounding_distance, grounding_probability, map_summary
from narrows.simulation.voyage import Voyage
from narrows.waterway.waterway import Section, Waterway

PANEL_GREY = "#5A5A5A"
# Width of a track, height of a panel below it [in].
TRACK, HISTORY = 5.6, 0.9
DEGREES = 180 / math.pi
# Time histories of a voyage: unit, factor, and words by name.
HISTORIES = (
    ("deg", DEGREES, {"psi": "heading", "rudder": "rudder"}), ("deg/s", DEGREES, {"r": "yaw rate"}),
    ("m/s", 1.0, {"u": "surge", "v": "sway"}),
)  # fmt: skip
BANK_POINTS = 400
SIDES = {-1: ("port", BLUE, "o", "Blues_r"), 1: ("starboard", ORANGE, "^", "Oranges_r")}
# Drawn shape of a hull with contact at midship alone: over length and beam.
BOW = ((-0.5, -0.5), (-0.5, 0.5), (0.35, 0.5), (0.5, 0.0), (0.35, -0.5))


def voyage_figure(voyage: Voyage) -> Figure:
    if given := given_axes():
        figure, axes = given
        _draw_path(axes, voyage)
        titled(axes, [voyage.outcome.sentence])
        return figure
    with rc_context(FONT):
        figure = Picture(figsize=(WIDTH, WIDTH), layout="constrained")
        grid = figure.add_gridspec(1 + len(HISTORIES), 1)
        above, *below = (figure.add_subplot(grid[row]) for row in range(grid.nrows))
        _draw_path(above, voyage)
        for axes, (unit, factor, names) in zip(below, HISTORIES, strict=True):
            for (name, words), colour, style in zip(names.items(), (BLUE, ORANGE), DASHES, strict=False):
                if name != "rudder" or np.ptp(voyage.rudder) > 0:
                    axes.plot(voyage.t, factor * voyage[name], color=colour, linestyle=style, label=words)
            axes.set_ylabel(f"[{unit}]")
            axes.sharex(below[-1])
            axes.tick_params(labelbottom=axes is below[-1])
            axes.grid(alpha=0.3)
            axes.legend(frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))
        below[-1].set_xlabel("time [s]")
        (left, right), (low, top) = above.get_xlim(), above.get_ylim()
        high = min(max(TRACK * abs((top - low) / (right - left)), 0.7), 0.6 * TRACK)
        grid.set_height_ratios([high, *(HISTORY for _ in below)])
        figure.set_figheight(high + len(below) * (HISTORY + 0.3) + 1.4)
        headed(figure, *described(voyage))
        notes_below(figure, voyage.outcome.notes)
    return figure


def _draw_path(axes: Axes, voyage: Voyage) -> None:
    if voyage.waterway is None:
        paths_on(axes, [voyage])
    else:
        track_on_map(axes, voyage, voyage.waterway)


def described(voyage: Voyage) -> tuple[str, list[str]]:
    rudder = float(np.degrees(voyage.rudder[0])) if len(voyage.rudder) else 0.0
    helm = f", rudder {rudder:.3g} deg" if rudder and not np.ptp(voyage.rudder) else ""
    where = voyage.waterway.name if voyage.waterway else voyage.configuration.canal.in_words
    speed = float(np.hypot(voyage.u[0], voyage.v[0]))
    start = f"At {speed:.3g} m/s ({speed / KNOT:.3g} knots){helm}."
    return f"{voyage.configuration.ship.in_words}, in {where}", [f"{start} {voyage.outcome.ending}"]


def track_on_map(axes: Axes, voyage: Voyage, waterway: Waterway) -> None:
    length, colour = voyage.configuration.ship.length, _colour(voyage)
    near, far = (float(end) for end in (voyage.x.min() - 2 * length, voyage.x.max() + 2 * length))
    s = np.linspace(max(near, 0.0), min(far, waterway.line.length), BANK_POINTS)
    _banks_on_map(axes, waterway, s, waterway.keel_section(s, voyage.configuration.ship.draft))
    path, heading = waterway.to_map(voyage.x, voyage.y, voyage.psi)
    axes.plot(*path.T, color=colour, linewidth=1.0)
    for i in {*range(0, len(path) - 1, max(1, len(path) // 6)), len(path) - 1}:
        ahead = np.array([np.sin(heading[i]), np.cos(heading[i])])
        shape = _shape(voyage) @ np.array([ahead, [ahead[1], -ahead[0]]]) + path[i]
        axes.add_patch(_drawn(shape, colour if i == len(path) - 1 else PANEL_GREY, 0.7 if i == len(path) - 1 else 0.25))


def _banks_on_map(axes: Axes, waterway: Waterway, s: np.ndarray, section: Section) -> None:
    for sign in (-1, 1):
        bank, _ = waterway.to_map(s, section.middle + sign * section.width / 2)
        axes.plot(*bank.T, color=PANEL_GREY, linewidth=2)
    origin = "" if waterway.origin is None else f" of {waterway.origin[0]:.5g} E, {waterway.origin[1]:.5g} N"
    axes.set(aspect="equal", xlabel=f"east{origin} [m]", ylabel="north [m]")


def waterway_figure(waterway: Waterway) -> Figure:
    figure, axes = panels(1, 1, 4.0, grid="")
    s = np.linspace(0.0, waterway.line.length, BANK_POINTS)
    _banks_on_map(axes[0, 0], waterway, s, waterway.section(s))
    headed(figure, waterway.name, [waterway.summary().partition(": ")[2]])
    return figure


def paths_figure(voyages: Sequence[Voyage]) -> Figure:
    figure, axes = panels(1, 1, 3.6, grid="")
    paths_on(axes[0, 0], voyages)
    return figure


def paths_on(axes: Axes, voyages: Sequence[Voyage]) -> None:
    length = voyages[0].configuration.ship.length
    far, near = max(float(v.x.max()) for v in voyages) + length, min(float(v.x.min()) for v in voyages) - length
    half = banks_on(axes, near, far, voyages[0])
    for voyage in voyages:
        colour = _colour(voyage)
        axes.plot(voyage.x, voyage.y, color=colour, linewidth=1.0, linestyle="-" if colour == BLUE else "--")
        axes.add_patch(hull(voyage, len(voyage.x) - 1, colour))
    if len(voyages) == 1:
        for i in range(0, len(voyages[0].x) - 1, max(1, len(voyages[0].x) // 6)):
            axes.add_patch(hull(voyages[0], i, PANEL_GREY, 0.25))
    axes.set(xlim=(near, far), ylim=(half * 1.12, -half * 1.12), aspect="equal")
    axes.set_xlabel("along the canal x [m], starboard down")
    axes.set_ylabel("y [m]")


def banks_on(axes: Axes, near: float, far: float, voyage: Voyage) -> float:
    """Draw the banks along the line of a voyage, and return the distance of the farther one."""
    ends = [near, far]
    banks = [np.full(2, side * voyage.configuration.canal.width / 2) for side in (-1, 1)]
    if voyage.waterway is not None:
        ends = np.linspace(max(near, 0.0), min(far, voyage.waterway.line.length), BANK_POINTS).tolist()
        clear = voyage.waterway.keel_section(np.array(ends), voyage.configuration.ship.draft)
        banks = [clear.middle + side * clear.width / 2 for side in (-1, 1)]
    for bank in banks:
        axes.plot(ends, bank, color=PANEL_GREY, linewidth=2)
        axes.fill_between(ends, bank, bank * 1.12, color=PANEL_GREY, alpha=0.35, linewidth=0)
    return float(np.abs(banks).max())


def _colour(voyage: Voyage) -> str:
    side = {"starboard": 1, "port": -1}.get(voyage.outcome.side or "", 0)
    return SIDES[side][1] if side else PANEL_GREY


def hull(voyage: Voyage, i: int, colour: str, alpha: float = 0.7) -> Polygon:
    """Outline the ship at one row of a voyage, by the points that meet a bank."""
    c, s = math.cos(voyage.psi[i]), math.sin(voyage.psi[i])
    return _drawn(_shape(voyage) @ np.array([[c, s], [-s, c]]) + [voyage.x[i], voyage.y[i]], colour, alpha)


def _shape(voyage: Voyage) -> np.ndarray:
    """Points of the hull, forward and starboard of midship [m]."""
    ship = voyage.configuration.ship
    return np.array(voyage.outline) if voyage.outline else np.array(BOW) * [ship.length, ship.beam]


def _drawn(corners: np.ndarray, colour: str, alpha: float) -> Polygon:
    return Polygon(corners, closed=True, facecolor=colour, edgecolor="black", linewidth=0.6, alpha=alpha)


def distances_figure(
    distances: Mapping[str, xr.DataArray], sides: Mapping[str, xr.DataArray], configuration: Configuration
) -> Figure:
    figure, ((axes,),) = panels(1, 1, 3.8)
    edge = (configuration.canal.width - configuration.ship.beam) / 2
    for i, (name, distance) in enumerate(distances.items()):
        clearance, colour = edge - distance["y"], (BLUE, ORANGE, "#009E73", "#CC79A7")[i % 4]
        axes.plot(clearance, distance, color=colour, linestyle=("-", "--", "-.", ":")[i % 4], label=name)
        axes.plot(clearance, distance.where(sides[name] > 0), color=colour, linewidth=4, alpha=0.5)
    axes.set_xlabel("starboard clearance at the start $y_s(0)$ [m]; thick: grounds to starboard")
    axes.set_ylabel("distance to grounding [m]")
    axes.legend(frameon=False)
    return figure


LABELS = {
    "x": "start along the waterway x(0) [m]",
    "y": "start to starboard of the centreline y(0) [m]",
    "u": "surge velocity u [m/s]",
    "psi": "heading at the start [deg]",
    "width": "canal width W [m]",
}


def map_figure(
    voyages: xr.Dataset, model: Model | None, within: float | None = None, waterway: Waterway | None = None,
    start: Mapping[str, Any] | None = None,
) -> Figure:  # fmt: skip
    """Draw a map of voyages: distance to grounding over one or two dimensions, or its probability.

    Raises an InputError if there are more than two dimensions besides the samples.

    Parameters
    ----------
    voyages : Dataset
        Result of ``ensemble``.
    model : Model, optional
        The ship and its tested range; without it all is marked as untested.
    within : float [m], optional
        Draw the probability of grounding within this distance, over the samples.
    waterway : Waterway, optional
        Waterway instead of the model's own canal.
    start : mapping of str to number, optional
        Fixed quantities: u [m/s], psi [rad] and the like, for the title.
    """
    quantity = grounding_distance(voyages) if within is None else grounding_probability(voyages, within)
    if within is None and "sample" in quantity.dims:
        quantity = quantity.median("sample", keep_attrs=True)
        voyages = voyages.isel(sample=0)
    notes = str(voyages.attrs.get("notes", "")).splitlines()
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
            at, words = _scaled(quantity, dims[0]), textwrap.wrap(str(map_summary(voyages)["summary"]), 60)
            axes.set(xlim=(float(at.min()), float(at.max())), yticks=[])
            axes.text(0.5, 0.5, "\n".join(words), transform=axes.transAxes, ha="center", va="center")
        axes.set_xlabel(LABELS.get(dims[0], dims[0]))
        keys += _mark_tested(axes, quantity, model)
        axes.legend(handles=keys, frameon=False, loc="upper left", bbox_to_anchor=(0.0, -0.14), ncols=3)
        if model and dims == ["y"] and within is None and waterway is None:
            edge = (model.configuration.canal.width - model.configuration.ship.beam) / 2
            top: Any = axes.secondary_xaxis("top", functions=(lambda y: edge - y,) * 2)
            top.set_xlabel("starboard clearance at the start $y_s(0)$ [m]")
        notes_below(figure, notes)
        if model:
            headed(figure, *_title(model.configuration, waterway, start or {}))
    return figure


def _title(configuration: Configuration, waterway: Waterway | None, start: Mapping[str, Any]) -> tuple[str, list[str]]:
    where = waterway.name if waterway else configuration.canal.in_words
    parts = [f"{configuration.ship.in_words}, in {where}"]
    held = {name: float(value) for name, value in start.items() if np.ndim(value) == 0}
    if "u" in held:
        parts.append(f"{held['u']:.3g} m/s ({held['u'] / KNOT:.3g} knots)")
    parts += [f"heading {np.degrees(held['psi']):.3g} deg"] if held.get("psi") else []
    parts += [f"rudder {np.degrees(held['rudder']):.3g} deg"] if held.get("rudder") else []
    return parts[0], ["; ".join(parts[1:])]


def _mark_tested(axes: Axes, quantity: xr.DataArray, model: Model | None) -> list[Any]:
    known, nothing = model.data_range if model and model.has_bank else DataRange(), (np.inf, np.inf)
    tested = {"y": (-known.abs_y[1], known.abs_y[1]) if known.abs_y else nothing, "u": known.speed or nothing}
    marked = False
    for axis, name in enumerate(str(name) for name in quantity.dims):
        if name in tested:
            marked |= _hatch_beyond(axes, axis, tested[name])
    for name, (low, high) in tested.items():  # A curve at one speed may be untested as a whole.
        if name in quantity.coords and not quantity[name].ndim and not low <= float(quantity[name]) <= high:
            marked |= _hatch_beyond(axes, 0, nothing)
    look: dict[str, Any] = {"facecolor": "none", "edgecolor": PURPLE, "hatch": ".."}
    return [Patch(label="not tested: extrapolated", **look)] if marked else []


def _hatch_beyond(axes: Axes, axis: int, covered: tuple[float, float]) -> bool:
    low, high = (axes.get_ylim if axis else axes.get_xlim)()
    ends = ((low, min(covered[0], high)), (max(covered[1], low), high))
    bands = [(start, stop) for start, stop in ends if start < stop]
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
            if not chosen.notnull().any():
                continue
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


FRAMES_A_SECOND = 15
LONGEST = 120.0  # Longest animation [s]
LENGTHS = 3.0  # Visible distance ahead and astern [ship lengths]


def animation_of(voyage: Voyage, path: str | Path | None = None, seconds: float = 8.0) -> FuncAnimation:
    """Make an animation of a voyage in its canal, and write it if a path is given."""
    if not 0 < seconds <= LONGEST:
        raise InputError(f"seconds = {shown(seconds)}: give the length of a film, up to {LONGEST:g} s")
    form = None if path is None else form_of(path, (".gif", ".html"))
    film = _film(voyage, max(2, round(FRAMES_A_SECOND * seconds)))
    if path is not None:
        with TemporaryDirectory() as folder:
            if form == ".gif":
                film.save(Path(folder) / "film.gif", writer=PillowWriter(fps=FRAMES_A_SECOND))
            made = film.to_jshtml(FRAMES_A_SECOND) if form == ".html" else (Path(folder) / "film.gif").read_bytes()
        write_whole(path, made)
    return film


def _film(voyage: Voyage, frames: int) -> FuncAnimation:
    length = voyage.configuration.ship.length
    near, far = float(voyage.x.min()) - length, float(voyage.x.max()) + 2 * LENGTHS * length
    with rc_context(FONT):
        figure = Picture(figsize=(WIDTH, 3.4), layout="constrained")
        axes = figure.subplots()
        half = banks_on(axes, near, far, voyage)
        axes.set(ylim=(half * 1.12, -half * 1.12), aspect="equal")
        axes.set(xlabel="along the canal x [m], starboard down", ylabel="y [m]")
        (path,) = axes.plot([], [], color=BLUE, linewidth=1.0)
        ship = hull(voyage, 0, BLUE)
        axes.add_patch(ship)
    rows = np.searchsorted(voyage.t, np.linspace(voyage.t[0], voyage.t[-1], frames)).clip(max=len(voyage) - 1)

    def show(row: int) -> tuple[Any, ...]:
        ship.set_xy(hull(voyage, row, BLUE).get_xy())
        path.set_data(voyage.x[: row + 1], voyage.y[: row + 1])
        left = max(near, float(voyage.x[row]) - LENGTHS * length)
        axes.set_xlim(left, left + 2 * LENGTHS * length)
        titled(axes, [f"{voyage.t[row]:.1f} s" if row < len(voyage) - 1 else voyage.outcome.sentence])
        return path, ship

    return FuncAnimation(figure, show, frames=rows.tolist(), interval=1000 / FRAMES_A_SECOND)
