"""Figures of voyages: paths in the canal, an animation, maps of groundings, turning circles and zigzags."""

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

import narrows as nw
from narrows.base.errors import InputError, shown
from narrows.base.files import form_of, write_whole
from narrows.quantities.names import KNOT
from narrows.report.colours import BLUE, DASHES, GREEN, GREY, ORANGE, PURPLE
from narrows.report.style import FONT, GIVEN, WIDTH, headed, notes_below, panels, titled
from narrows.simulation.ensemble import grounding_probability, map_summary
from narrows.studies.mikkelsen2025 import Reproduction
from narrows.waterway.waterway import Section

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
COLOURS = (BLUE, ORANGE, GREEN, PURPLE)
SIDES = {-1: ("port", BLUE, "o", "Blues_r"), 1: ("starboard", ORANGE, "^", "Oranges_r")}
# Drawn shape of a hull with contact at midship alone: over length and beam.
BOW = ((-0.5, -0.5), (-0.5, 0.5), (0.35, 0.5), (0.5, 0.0), (0.35, -0.5))


def voyage_figure(voyage: nw.Voyage) -> Figure:
    with rc_context(FONT):
        if GIVEN.get() is not None:
            figure, ((above,),) = panels(1, 1, WIDTH, "")
            _draw_path(above, voyage)
            titled(above, [voyage.outcome.sentence])
            return figure
        figure, axes = panels(1 + len(HISTORIES), 1, WIDTH, "")
        above, *below = axes[:, 0]
        _draw_path(above, voyage)
        for panel, (unit, factor, names) in zip(below, HISTORIES, strict=True):
            for (name, words), colour, style in zip(names.items(), (BLUE, ORANGE), DASHES, strict=False):
                if name != "rudder" or np.ptp(voyage.rudder) > 0:
                    panel.plot(voyage.t, factor * voyage[name], color=colour, linestyle=style, label=words)
            panel.set_ylabel(f"[{unit}]")
            panel.sharex(below[-1])
            panel.tick_params(labelbottom=panel is below[-1])
            panel.grid(alpha=0.3)
            panel.legend(frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))
        below[-1].set_xlabel("time [s]")
        (left, right), (low, top) = above.get_xlim(), above.get_ylim()
        high = min(max(TRACK * abs((top - low) / (right - left)), 0.7), 0.6 * TRACK)
        above.get_gridspec().set_height_ratios([high, *(HISTORY for _ in below)])
        figure.set_figheight(high + len(below) * (HISTORY + 0.3) + 1.4)
        rudder = float(np.degrees(voyage.rudder[0])) if len(voyage.rudder) else 0.0
        helm = f", rudder {rudder:.3g} deg" if rudder and not np.ptp(voyage.rudder) else ""
        where = voyage.waterway.name if voyage.waterway else voyage.configuration.canal.in_words
        speed = float(np.hypot(voyage.u[0], voyage.v[0]))
        start = f"At {speed:.3g} m/s ({speed / KNOT:.3g} knots){helm}."
        headed(figure, f"{voyage.configuration.ship.in_words}, in {where}", [f"{start} {voyage.outcome.ending}"])
        notes_below(figure, voyage.outcome.notes)
        return figure


def _draw_path(axes: Axes, voyage: nw.Voyage) -> None:
    if voyage.waterway is None:
        paths_on(axes, [voyage])
        return
    length, waterway = voyage.configuration.ship.length, voyage.waterway
    near, far = (float(end) for end in (voyage.x.min() - 2 * length, voyage.x.max() + 2 * length))
    s = np.linspace(max(near, 0.0), min(far, waterway.line.length), BANK_POINTS)
    _banks_on_map(axes, waterway, s, waterway.section(s, voyage.configuration.ship.draft))
    path, _ = waterway.to_map(voyage.x, voyage.y, voyage.psi)
    axes.plot(*path.T, color=_colour(voyage), linewidth=1.0)
    _hulls_on(axes, voyage, on_map=True)


def _banks_on_map(axes: Axes, waterway: nw.Waterway, s: np.ndarray, section: Section) -> None:
    for sign in (-1, 1):
        bank, _ = waterway.to_map(s, section.middle + sign * section.width / 2)
        axes.plot(*bank.T, color=PANEL_GREY, linewidth=2)
    origin = "" if waterway.origin is None else f" of {waterway.origin[0]:.5g} E, {waterway.origin[1]:.5g} N"
    axes.set(aspect="equal", xlabel=f"east{origin} [m]", ylabel="north [m]")


def waterway_figure(waterway: nw.Waterway) -> Figure:
    figure, axes = panels(1, 1, 4.0, grid="")
    s = np.linspace(0.0, waterway.line.length, BANK_POINTS)
    _banks_on_map(axes[0, 0], waterway, s, waterway.section(s))
    headed(figure, waterway.name, [waterway.summary().partition(": ")[2]])
    return figure


def paths_figure(reproduced: Reproduction) -> Figure:
    figure, axes = panels(1, 1, 3.6, grid="")
    paths_on(axes[0, 0], list(reproduced.voyages.values()))
    return figure


def paths_on(axes: Axes, voyages: Sequence[nw.Voyage]) -> None:
    length = voyages[0].configuration.ship.length
    far, near = max(float(v.x.max()) for v in voyages) + length, min(float(v.x.min()) for v in voyages) - length
    half = banks_on(axes, near, far, voyages[0])
    for voyage in voyages:
        colour = _colour(voyage)
        axes.plot(voyage.x, voyage.y, color=colour, linewidth=1.0, linestyle="-" if colour == BLUE else "--")
        axes.add_patch(hull(voyage, len(voyage.x) - 1, colour))
    if len(voyages) == 1:
        _hulls_on(axes, voyages[0])
    axes.set(xlim=(near, far), ylim=(half * 1.12, -half * 1.12), aspect="equal", ylabel="y [m]", xlabel=ALONG)


ALONG = "along the canal x [m], starboard down"


def banks_on(axes: Axes, near: float, far: float, voyage: nw.Voyage) -> float:
    """Draw the banks along the line of a voyage, and return the distance of the farther one."""
    ends, middle, width = np.array([near, far]), np.zeros(2), np.full(2, voyage.configuration.canal.width)
    if voyage.waterway is not None:
        ends = np.linspace(max(near, 0.0), min(far, voyage.waterway.line.length), BANK_POINTS)
        width, middle = voyage.waterway.section(ends, voyage.configuration.ship.draft)[:2]
    banks = middle - width / 2, middle + width / 2
    for bank in banks:
        axes.plot(ends, bank, color=PANEL_GREY, linewidth=2)
        axes.fill_between(ends, bank, bank * 1.12, color=PANEL_GREY, alpha=0.35, linewidth=0)
    return float(np.abs(banks).max())


def _colour(voyage: nw.Voyage) -> str:
    return {"starboard": ORANGE, "port": BLUE}.get(voyage.outcome.side or "", PANEL_GREY)


def hull(voyage: nw.Voyage, i: int, colour: str, alpha: float = 0.7, on_map: bool = False) -> Polygon:
    """Outline the ship at one row of a voyage, by the points that meet a bank."""
    ship, place, psi = voyage.configuration.ship, np.array([voyage.x[i], voyage.y[i]]), voyage.psi[i]
    # Points forward and starboard of midship [m].
    points = np.array(voyage.outline) if voyage.outline else np.array(BOW) * [ship.length, ship.beam]
    turn = np.array([[math.cos(psi), math.sin(psi)], [-math.sin(psi), math.cos(psi)]])
    if on_map and voyage.waterway:
        place, heading = voyage.waterway.to_map(voyage.x[i], voyage.y[i], psi)
        turn = np.array([[math.sin(heading), math.cos(heading)], [math.cos(heading), -math.sin(heading)]])
    return Polygon(points @ turn + place, facecolor=colour, edgecolor="black", linewidth=0.6, alpha=alpha)


def _hulls_on(axes: Axes, voyage: nw.Voyage, on_map: bool = False) -> None:
    last = len(voyage.x) - 1
    for i in range(0, last, max(1, last // 6)):
        axes.add_patch(hull(voyage, i, PANEL_GREY, 0.25, on_map))
    axes.add_patch(hull(voyage, last, _colour(voyage), on_map=on_map))


def distances_figure(reproduced: Reproduction) -> Figure:
    figure, ((axes,),) = panels(1, 1, 3.8)
    configuration = reproduced.truth.configuration
    edge = (configuration.canal.width - configuration.ship.beam) / 2
    for (name, voyages), colour, style in zip(reproduced.readings.items(), COLOURS, DASHES, strict=False):
        distance = voyages["distance"].where(voyages["grounded"])
        axes.plot(edge - distance["y"], distance, color=colour, linestyle=style, label=name)
        axes.plot(edge - distance["y"], distance.where(voyages["side"] > 0), color=colour, linewidth=4, alpha=0.5)
    axes.set(ylabel="distance to grounding [m]")
    axes.set_xlabel("starboard clearance at the start $y_s(0)$ [m]; thick: grounds to starboard")
    axes.legend(frameon=False)
    return figure


LABELS = {
    "x": "start along the waterway x(0) [m]",
    "y": "start to starboard of the centreline y(0) [m]",
    "u": "surge velocity u [m/s]",
    "psi": "heading at the start [deg]",
    "width": "canal width W [m]",
}


@rc_context(FONT)
def map_figure(
    voyages: xr.Dataset, model: nw.Model | None, within: float | None = None, waterway: nw.Waterway | None = None,
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
    if within is None:
        quantity = voyages["distance"].where(voyages["grounded"]).assign_attrs(long_name="distance to grounding")
    else:
        quantity = grounding_probability(voyages, within)
    if within is None and "sample" in quantity.dims:
        quantity = quantity.median("sample", keep_attrs=True)
        voyages = voyages.isel(sample=0)
    dims = [str(name) for name in quantity.dims]
    if len(dims) not in (1, 2):
        raise InputError(f"a picture has one or two dimensions, and this map has {len(dims)}: {', '.join(dims)}")
    figure, ((axes,),) = panels(1, 1, 4.8, "")
    keys: list[Any] = []
    at = [np.degrees(quantity[name]) if name == "psi" else quantity[name] for name in dims]
    if quantity.notnull().any():
        keys = (_line if len(dims) == 1 else _field)(axes, at, quantity, voyages["side"], within is None)
    else:
        words = textwrap.wrap(str(map_summary(voyages)["summary"]), 60)
        axes.set(xlim=(float(at[0].min()), float(at[0].max())), yticks=[])
        axes.text(0.5, 0.5, "\n".join(words), transform=axes.transAxes, ha="center", va="center")
    axes.set_xlabel(LABELS.get(dims[0], dims[0]))
    keys += _mark_tested(axes, quantity, model)
    axes.legend(handles=keys, frameon=False, loc="upper left", bbox_to_anchor=(0.0, -0.14), ncols=3)
    if model and dims == ["y"] and within is None and waterway is None:
        edge = (model.configuration.canal.width - model.configuration.ship.beam) / 2
        top: Any = axes.secondary_xaxis("top", functions=(lambda y: edge - y,) * 2)
        top.set_xlabel("starboard clearance at the start $y_s(0)$ [m]")
    notes_below(figure, str(voyages.attrs.get("notes", "")).splitlines())
    if model:
        where = waterway.name if waterway else model.configuration.canal.in_words
        held = {name: float(value) for name, value in (start or {}).items() if np.ndim(value) == 0}
        parts = [f"{held['u']:.3g} m/s ({held['u'] / KNOT:.3g} knots)"] if "u" in held else []
        angles = (("psi", "heading"), ("rudder", "rudder"))
        parts += [f"{words} {np.degrees(held[name]):.3g} deg" for name, words in angles if held.get(name)]
        headed(figure, f"{model.configuration.ship.in_words}, in {where}", ["; ".join(parts)])
    return figure


def _mark_tested(axes: Axes, quantity: xr.DataArray, model: nw.Model | None) -> list[Any]:
    known, nothing = model.data_range if model and model.has_bank else nw.DataRange(), (np.inf, np.inf)
    tested = {"y": (-known.abs_y[1], known.abs_y[1]) if known.abs_y else nothing, "u": known.speed or nothing}
    marked = False
    for name, (low, high) in tested.items():
        if name in quantity.dims:
            marked |= _hatch_beyond(axes, quantity.dims.index(name), (low, high))
        elif name in quantity.coords and not low <= float(quantity[name]) <= high:
            marked |= _hatch_beyond(axes, 0, nothing)  # A curve at one speed may be untested as a whole.
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


def _said(quantity: xr.DataArray) -> str:
    return f"{quantity.attrs['long_name']} [{quantity.attrs['units']}]"


def _line(axes: Axes, at: list[Any], quantity: xr.DataArray, side: xr.DataArray, by_side: bool) -> list[Any]:
    if not by_side:
        axes.plot(at[0], quantity, color=BLUE)
    for code, (word, colour, marker, _) in SIDES.items() if by_side else ():
        if (chosen := quantity.where(side == code)).notnull().any():
            label = f"grounds to {word}"
            axes.plot(at[0], chosen, color=colour, marker=marker, markersize=3, linewidth=1, label=label)
    axes.set_ylabel(_said(quantity))
    axes.grid(alpha=0.3)
    return list(axes.get_legend_handles_labels()[0])


def _field(axes: Axes, at: list[Any], quantity: xr.DataArray, side: xr.DataArray, by_side: bool) -> list[Any]:
    if not by_side:
        mesh = axes.pcolormesh(*at, quantity.T, cmap="cividis", vmin=0, vmax=1, shading="nearest")
        axes.figure.colorbar(mesh, ax=axes, label=_said(quantity))
    top = float(np.nanmax(quantity)) if np.isfinite(quantity).any() else 1.0
    for code, (word, _, _, colours) in SIDES.items() if by_side else ():
        part = quantity.where(side == code)
        mesh = axes.pcolormesh(*at, part.T, cmap=colours, vmin=0, vmax=1.2 * top, shading="nearest")
        axes.figure.colorbar(mesh, ax=axes, label=f"to {word}: {_said(quantity)}", pad=0.02)
    axes.set_ylabel(LABELS.get(up := str(quantity.dims[1]), up))
    white = by_side and quantity.isnull().any()
    return [Patch(facecolor="white", edgecolor=GREY, lw=0.6, label="does not ground")] if white else []


FRAMES_A_SECOND = 15
LONGEST = 120.0  # Longest animation [s]
LENGTHS = 3.0  # Visible distance ahead and astern [ship lengths]


@rc_context(FONT)
def animation_of(voyage: nw.Voyage, path: str | Path | None = None, seconds: float = 8.0) -> FuncAnimation:
    """Make an animation of a voyage in its canal, and write it if a path is given."""
    if not 0 < seconds <= LONGEST:
        raise InputError(f"seconds = {shown(seconds)}: give the length of a film, up to {LONGEST:g} s")
    form = None if path is None else form_of(path, (".gif", ".html"))
    length = voyage.configuration.ship.length
    near, far = float(voyage.x.min()) - length, float(voyage.x.max()) + 2 * LENGTHS * length
    figure, ((axes,),) = panels(1, 1, 3.4, "")
    half = banks_on(axes, near, far, voyage)
    axes.set(ylim=(half * 1.12, -half * 1.12), aspect="equal", xlabel=ALONG, ylabel="y [m]")
    (line,) = axes.plot([], [], color=BLUE, linewidth=1.0)
    ship = axes.add_patch(hull(voyage, 0, BLUE))
    times = np.linspace(voyage.t[0], voyage.t[-1], max(2, round(FRAMES_A_SECOND * seconds)))
    rows = np.searchsorted(voyage.t, times).clip(max=len(voyage) - 1)

    def show(row: int) -> None:
        ship.set_xy(hull(voyage, row, BLUE).get_xy())
        line.set_data(voyage.x[: row + 1], voyage.y[: row + 1])
        left = max(near, float(voyage.x[row]) - LENGTHS * length)
        axes.set_xlim(left, left + 2 * LENGTHS * length)
        titled(axes, [f"{voyage.t[row]:.1f} s" if row < len(voyage) - 1 else voyage.outcome.sentence])

    film = FuncAnimation(figure, show, frames=rows.tolist(), interval=1000 / FRAMES_A_SECOND)
    if path and form == ".html":
        write_whole(path, film.to_jshtml(FRAMES_A_SECOND))
    elif path:
        with TemporaryDirectory() as folder:
            film.save(whole := Path(folder) / "film.gif", writer=PillowWriter(fps=FRAMES_A_SECOND))
            write_whole(path, whole.read_bytes())
    return film


# Turning circles and zigzags.
LEGEND: dict[str, Any] = {
    "frameon": False, "loc": "lower center", "bbox_to_anchor": (0.5, 1.0), "ncols": 2, "fontsize": 7,
}  # fmt: skip


def manoeuvres_figure(trials: nw.Trials) -> Figure:
    figure, axes = panels(1, 2, 3.6)
    _circles_on(axes[0, 0], {f"rudder {order} deg": circle for order, circle in trials.turning.items()})
    _zigzags_on(axes[0, 1], {order: test for order, test in trials.zigzags.items() if order.startswith("+")})
    return figure


def manoeuvre_figure(result: nw.Turning | nw.ZigzagTest) -> Figure:
    figure, ((axes,),) = panels(1, 1, 4.2 if isinstance(result, nw.Turning) else 3.2)
    if isinstance(result, nw.Turning):
        _circles_on(axes, {result.summary().partition(":")[0].lower(): result})
    else:
        _zigzags_on(axes, {"": result})
    notes_below(figure, result.notes)
    return figure


def _circles_on(axes: Axes, circles: Mapping[str, nw.Turning]) -> None:
    for (label, circle), colour, dash in zip(circles.items(), COLOURS, DASHES, strict=False):
        voyage, length = circle.voyage, circle.voyage.configuration.ship.length
        axes.plot(voyage.y / length, voyage.x / length, color=colour, ls=dash, label=label)
    axes.set(aspect="equal", xlabel="transfer [ship lengths], starboard positive", ylabel="advance [ship lengths]")
    axes.legend(**LEGEND)


def _zigzags_on(axes: Axes, tests: Mapping[str, nw.ZigzagTest]) -> None:
    for (order, test), colour in zip(tests.items(), COLOURS, strict=False):
        voyage = test.voyage
        time = voyage.t * voyage.u[0] / voyage.configuration.ship.length
        axes.plot(time, np.degrees(voyage.psi), color=colour, label=f"heading, zigzag {order}" if order else "heading")
        axes.plot(time, np.degrees(voyage.rudder), color=colour, ls=":", label="its rudder" if order else "rudder")
    axes.set_xlabel("time [ship lengths at the approach speed]")
    axes.set_ylabel("heading, rudder [deg],\nstarboard positive")
    axes.legend(**LEGEND)
