"""The envelope chart for pilots: where the ship is safe, and the rudder that holds it; along a waterway."""

import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from narrows.quantities.names import KNOT
from narrows.report.colours import BLACK, BLUE, DASHES, GREY, ORANGE, PURPLE
from narrows.report.printed_tables import console_of, is_verbose, print_notes, print_result, table_of, thinned
from narrows.report.style import FONT, GIVEN, headed, panels, titled
from narrows.safety.envelope_along import EnvelopeAlong
from narrows.safety.headline import runs
from narrows.safety.result import MEDIAN, SafeEnvelope
from narrows.safety.settings import SURE_SHARE

PALE, PALER = "#7FB8DA", "#D6E8F3"
UNTESTED = "\\\\\\"
# A4, upright [in]: its letters remain legible on a screen of the same width.
PAGE = (8.27, 11.69)


@rc_context(FONT)
def envelope_chart(envelope: SafeEnvelope) -> Figure:
    if GIVEN.get() is not None:
        figure, ((axes,),) = panels(1, 1, PAGE[1], "")
        keys = _draw_speeds(axes, envelope)
        axes.legend(handles=keys, frameon=False, fontsize=7)
        titled(axes, [envelope.description, envelope.weather, envelope.summary()])
        return figure
    figure, ((speeds,), (rudder,), (foot,)) = panels(3, 1, PAGE[1], "", PAGE[0], height_ratios=(4.0, 3.4, 0.7))
    rudder.sharex(speeds)
    keys = _draw_speeds(speeds, envelope)
    _draw_rudder(rudder, envelope)
    others = (note for note in envelope.notes if note.partition(". ")[0] not in envelope.summary())
    notes = [textwrap.shorten(note, LETTERS, placeholder=" ...") for note in (*envelope.limits, *others)]
    foot.axis("off")
    foot.text(0.0, 1.0, "\n".join(notes[:MOST_NOTES]), fontsize=SMALL, va="top", transform=foot.transAxes)
    figure.legend(handles=keys, loc="outside lower left", frameon=False, ncols=3, fontsize=7.5)
    headed(figure, f"{envelope.description}; {envelope.weather}", [envelope.answer, envelope.trust])
    return figure


def _draw_speeds(axes: Axes, envelope: SafeEnvelope) -> list[Any]:
    """Draw contours of the shares of cases, none between untested speeds; return legend keys."""
    envelope = _widened(envelope)
    data = envelope.data.transpose("u", "y", ...)
    y, u = data["y"].to_numpy(), data["u"].to_numpy() / KNOT
    held, clear = data["held"].to_numpy(), data["clear"].to_numpy()[:, None]
    by_model = np.where(clear, held, 0.0)
    # Cells that may be drawn as safe: tested, in a tested section, and clear.
    counted = data["tested"].to_numpy() & clear & (not envelope.untested)
    if (by_model >= SURE_SHARE).any():  # The part that was tested is filled above it
        areas = axes.contourf(y, u, by_model, levels=[SURE_SHARE, 1.01], colors=["none"], hatches=[UNTESTED])
        areas.set_edgecolor(PURPLE)
        areas.set_linewidth(0.0)
    for name, colour, edge, width in (("known", PALER, BLUE, 0.9), ("held", PALE, BLACK, 1.8)):
        share = np.where(counted, data[name].to_numpy(), 0.0)
        if (share >= SURE_SHARE).any():
            axes.contourf(y, u, share, levels=[SURE_SHARE, 1.01], colors=[colour])
        _line(axes, y, u, share, SURE_SHARE, "-", width, edge)
    _line(axes, y, u, held, MEDIAN, "--", 1.0)
    for name in ("held_low", "held_high"):
        _line(axes, y, u, data[name].to_numpy(), SURE_SHARE, ":", 1.0)
    handles = _shade(axes, envelope, y, u)
    axes.set_ylabel("speed through the water [knots]")
    axes.set_ylim(u[0] - _half(u), u[-1] + _half(u))
    axes.grid(alpha=0.3)
    _draw_banks(axes, envelope)
    return [
        Patch(facecolor=PALE, edgecolor=BLACK, lw=1.7, label="safe with 95 % probability, same pilot for all cases"),
        Patch(facecolor=PALER, edgecolor=BLUE, lw=0.9, label="by a pilot with the true coefficients"),
        Line2D([], [], color=BLACK, ls="--", lw=1.0, label="safe in half of the cases"),
        Patch(facecolor="white", edgecolor=GREY, lw=0.6, label="not safe"),
        Patch(facecolor=GREY, alpha=0.35, label="the ship's side would be in the bank"),
        Line2D([], [], color=BLACK, ls=":", lw=1.0, label="95 % interval of the edge"),
        *handles,
    ]


def _line(
    axes: Axes, y: np.ndarray, u: np.ndarray, share: np.ndarray, level: float, style: str, width: float,
    colour: str = BLACK,
) -> None:  # fmt: skip
    if share.min() < level < share.max():
        axes.contour(y, u, share, levels=[level], colors=[colour], linestyles=[style], linewidths=[width])


def _widened(envelope: SafeEnvelope) -> SafeEnvelope:
    """Return an envelope of one offset or one speed as a strip about it, since contours need two."""
    data = envelope.data
    for name, half in (("y", sum(envelope.walls) / 50), ("u", 0.5 * KNOT)):
        if data.sizes[name] == 1:
            data = data.isel({name: [0, 0]}).assign_coords({name: data[name].item() + half * np.array([-1.0, 1.0])})
    return SafeEnvelope(data)


def _half(values: np.ndarray) -> float:
    return float(values[-1] - values[0]) / (len(values) - 1) / 2


def _shade(axes: Axes, envelope: SafeEnvelope, y: np.ndarray, u: np.ndarray) -> list[Any]:
    data, handles = envelope.data.transpose("y", "u", ...), list[Any]()
    for first, last in runs(~data["clear"].to_numpy()):
        ends = u[first] - _half(u), u[last] + _half(u)
        axes.axhspan(*ends, facecolor="white", edgecolor=ORANGE, hatch="///", lw=0, zorder=2.5)
    if not data["clear"].all():
        handles.append(Patch(facecolor="white", edgecolor=ORANGE, hatch="///", label="keel or choked canal"))
    (port, starboard), (slow, fast) = envelope.walls, (u[0] - _half(u), u[-1] + _half(u))
    # Offsets and speeds that were not computed should not look unsafe.
    look: dict[str, Any] = {"facecolor": "0.92", "lw": 0, "zorder": 0.5}
    for low, high in ((-abs(port), y[0]), (y[-1], starboard)):
        axes.axvspan(low, high, **look)
    for low, high in ((slow, u[0]), (u[-1], fast)):
        axes.axhspan(low, high, **look)
    handles.append(Patch(label="not computed", **look))
    far = data.attrs.get("tested_offset", (0.0, np.inf))[1]
    tested = [edge / KNOT for edge in data.attrs.get("tested_speed", ()) if slow < edge / KNOT < fast]
    lines = [axes.axhline(edge, color=PURPLE, lw=1.2) for edge in tested]
    inside = (edge for edge in (-far, far) if y[0] - _half(y) < edge < y[-1] + _half(y))
    lines += [axes.axvline(edge, color=PURPLE, lw=1.2) for edge in inside]
    handles += [Line2D([], [], color=PURPLE, lw=1.2, label="end of the tested range")] * bool(lines)
    if envelope.untested or not data["tested"].all():
        handles.append(Patch(fc="none", edgecolor=PURPLE, hatch=UNTESTED, label="safe by the model, not tested"))
    return handles


def _draw_rudder(axes: Axes, envelope: SafeEnvelope) -> None:
    limit, reserve = float(np.degrees(envelope.data.attrs["rudder_limit"])), envelope.data.attrs["reserve"]
    data = envelope.data
    sailed = np.flatnonzero(data["clear"].to_numpy() | ~data["clear"].to_numpy().any())
    for shade, style, index in zip((0.15, 0.0), DASHES, np.unique(sailed[[0, -1]]).tolist(), strict=False):
        here = data.isel(u=index)
        label = f"at {float(here['u']) / KNOT:.1f} knots"
        band, edge = here.isel(y=np.isfinite(here["rudder"].to_numpy())), 1.2 * limit
        low, high = (
            np.nan_to_num(np.degrees(band[name].to_numpy()), nan=end, posinf=edge, neginf=-edge)
            for name, end in (("rudder_low", -edge), ("rudder_high", edge))
        )
        axes.fill_between(band["y"], low, high, facecolor=ORANGE, alpha=shade, lw=0)
        axes.plot(band["y"], low, color=ORANGE, ls=style, lw=1.0, label=f"9 cases of 10 within, {label}")
        axes.plot(band["y"], high, color=ORANGE, ls=style, lw=1.0)
        axes.plot(here["y"], np.degrees(here["rudder"]), color=BLUE, ls=style, label=f"most likely, {label}")
    place: dict[str, Any] = {"xycoords": axes.get_yaxis_transform(), "textcoords": "offset points", "zorder": 4}
    box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.5}
    for angle, words, colour, style in ((limit, "hard over", BLACK, "-"),
                                        ((1 - reserve) * limit, "reserve begins", GREY, "--")):  # fmt: skip
        for sign in (1, -1):
            axes.axhline(sign * angle, color=colour, lw=1.2, ls=style)
        axes.annotate(words, (0.03, angle), (0, 2.5), fontsize=7.5, color=colour, bbox=box, **place)
    axes.set_ylim(-1.2 * limit, 1.2 * limit)
    axes.set_xlabel("offset from the middle [m]: port is negative, starboard positive")
    axes.set_ylabel("rudder that holds it [deg]\npositive turns the bow to starboard")
    axes.legend(frameon=False, loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=2)
    axes.grid(alpha=0.3)
    _draw_banks(axes, envelope)


def _draw_banks(axes: Axes, envelope: SafeEnvelope) -> None:
    side, (port, starboard) = envelope.data.attrs["beam"] / 2, envelope.walls
    for sign, wall in ((-1, port), (1, starboard)):
        axes.axvspan(sign * (wall - side), sign * wall, color=GREY, alpha=0.35, lw=0)
        axes.axvline(sign * wall, color=BLACK, lw=3)
    axes.set_xlim(-1.02 * port, 1.02 * starboard)


# Font size of the notes [pt], legible on paper.
SMALL = 7.2
# Notes of one line, and their letters at that size; the terminal and the JSON have all notes.
MOST_NOTES, LETTERS = 6, 145


def print_envelope(envelope: SafeEnvelope) -> None:
    console = console_of(130)
    console.print(envelope.summary())
    tried = " to ".join(f"{u:.3g} m/s ({u / KNOT:.1f} knots)" for u in np.unique(envelope.data["u"][[0, -1]]))
    console.print(f"{envelope.description}; {envelope.weather}; {tried}, {envelope.samples} cases at each place.")
    console.print(table_of(OFFSET_COLUMNS, thinned(envelope.offset_rows()), left=("limited by",)))
    if is_verbose():
        speeds = [{**row, "mark": "" if row["keel_clear"] else " !"} for row in envelope.speed_rows()]
        console.print()
        console.print(table_of(SPEED_COLUMNS, speeds))
        console.print(f"\nPublished rules, for comparison:\n{envelope.rules.summary()}")
    else:
        console.print("Add --verbose for under-keel clearance by speed and for published design and canal rules.")
    print_notes(console, (*envelope.notes, *envelope.rules.notes))


OFFSET_COLUMNS = {
    "offset [m]": "{offset:+.1f}", "rudder [deg]": "{rudder:+.1f}", "95 % within [deg]": "{rudder_95:.1f}",
    "held": "{held:.0%}", "held, known ship": "{known:.0%}", "safe [kn]": "{lowest_speed:.1f} to {highest_speed:.1f}",
    "safe, known ship [kn]": "{highest_speed_known:.1f}", "50 % of cases [kn]": "{highest_speed_median:.1f}",
    "limited by": "{limited_by}",
}  # fmt: skip
SPEED_COLUMNS = {"speed [kn]": "{speed:.1f}", "under the keel [m]": "{keel_clearance:.2f}{mark}"}


def envelope_along_chart(along: EnvelopeAlong) -> Figure:
    figure, ((speed,), (offset,)) = panels(2, 1, 6.2, sharex=True)
    rows, edges, (s, *banks) = along.to_dataframe(), along.edges(), along.banks()
    _filled(speed, edges, rows, "lowest_speed", "highest_speed")
    _filled(offset, edges, rows, "port", "starboard", (s, *banks))
    for bank in banks:
        offset.plot(s, bank, color=BLACK, lw=2)
    offset.axhline(0.0, color=GREY, lw=0.8)
    for place in rows["computed_at"]:
        speed.axvline(place, ymax=0.03, color=GREY, lw=0.8)
    asked = np.concatenate([envelope.data["u"].to_numpy() for envelope in along.envelopes]) / KNOT
    speed.set_ylim(asked.min(), max(asked.max(), 1.05 * asked.min()))
    speed.set_ylabel("safe speeds [knots]")
    offset.set_ylabel("widest safe offsets [m]\nport above, starboard below")
    offset.invert_yaxis()
    offset.set_xlabel("distance along the waterway [m]; ticks: the computed sections")
    figure.legend(
        handles=[
            Patch(facecolor=PALE, edgecolor=BLACK, label="safe with 95 % probability"),
            Patch(facecolor="none", edgecolor=PURPLE, hatch=UNTESTED, label="safe by the model, not tested"),
            Patch(facecolor="white", edgecolor=GREY, lw=0.6, label="not safe, or not computed"),
            Line2D([], [], color=BLACK, lw=2, label="bank, at the keel"),
        ],
        loc="outside lower left", frameon=False, ncols=2,
    )  # fmt: skip
    summary = [along.envelopes[0].weather, along.summary()]
    headed(figure, f"Safe speeds and offsets along {along.waterway.name}", summary)
    return figure


def _filled(axes: Axes, edges: np.ndarray, rows: Any, low: str, high: str, banks: Sequence[np.ndarray] = ()) -> None:
    """Fill what is safe, between the banks if given, and hatch what is safe by the model alone."""
    looks: dict[str, dict[str, Any]] = {
        "_by_model": {"facecolor": "none", "edgecolor": PURPLE, "hatch": UNTESTED, "lw": 0.8},
        "": {"facecolor": PALE, "edgecolor": BLACK, "lw": 1.2},
    }
    for suffix, look in looks.items():
        bottom, top = (rows[f"{end}{suffix}"].to_numpy() for end in (low, high))
        for left, right, under, over in zip(edges, edges[1:], bottom, top, strict=False):
            if np.isfinite(over):
                s, *walls = banks or (edges,)
                inside = (s >= left) & (s <= right)
                ends = [np.clip(end, *(wall[inside] for wall in walls)) if walls else end for end in (under, over)]
                axes.fill_between(s[inside], *ends, **look)


COLUMNS = {
    "along [m]": "{distance:.0f}", "safe up to [kn]": "{highest_speed:.1f}{star}",
    "widest safe offsets [m]": "{port:+z.0f} to {starboard:+z.0f}", "at [kn]": "{at_speed:.1f}{star}",
    "limited by": "{limited_by}",
}  # fmt: skip


def print_envelope_along(along: EnvelopeAlong) -> None:
    rows = []
    for row in along.rows():
        by_model = {name.removesuffix("_by_model"): value for name, value in row.items() if name.endswith("_by_model")}
        starred = np.isfinite(by_model["highest_speed"]) and not np.isfinite(row["highest_speed"])
        rows.append({**row, **by_model, "star": "*"} if starred else {**row, "star": ""})
    key = "* safe by the model; no test covered that place" if any(row["star"] for row in rows) else None
    print_result(along, table_of(COLUMNS, rows, left=("limited by",), caption=key, caption_justify="left"))
