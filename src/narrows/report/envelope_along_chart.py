"""The chart along a waterway: the safe speeds and the widest safe offsets by distance."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from narrows.quantities.names import KNOT
from narrows.report.envelope_chart import PALE, UNTESTED
from narrows.report.printed_tables import print_result, table_of
from narrows.report.style import BLACK, GREY, PURPLE, headed, panels
from narrows.safety import EnvelopeAlong


def envelope_along_chart(along: EnvelopeAlong) -> Figure:
    figure, axes = panels(2, 1, 6.2, sharex=True)
    speed, offset = axes[:, 0]
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
    title = f"Safe speeds and offsets along {along.waterway.name}"
    headed(figure, title, [along.envelopes[0].weather, along.summary()])
    return figure


def _filled(
    axes: Axes, edges: np.ndarray, rows: Any, low: str, high: str, banks: tuple[np.ndarray, ...] = ()
) -> None:  # fmt: skip
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
    """Print the summary and one row per place; a star marks what is safe by the model and was not tested."""
    rows = []
    for row in along.rows():
        by_model = {name.removesuffix("_by_model"): value for name, value in row.items() if name.endswith("_by_model")}
        starred = np.isfinite(by_model["highest_speed"]) and not np.isfinite(row["highest_speed"])
        rows.append({**row, **by_model, "star": "*"} if starred else {**row, "star": ""})
    key = "* safe by the model; no test covered that place" if any(row["star"] for row in rows) else None
    print_result(along, table_of(COLUMNS, rows, left=("limited by",), caption=key, caption_justify="left"))
