"""A watched transit as one self-contained page, for training and for investigation."""

import math
from pathlib import Path

from narrows.files import write_whole
from narrows.report.fit_page import figure, render
from narrows.report.transit_figures import transit_figure, transit_track_figure
from narrows.warning.monitoring.watched_transit import WatchedTransit

TRACK = (
    "The canal from above, unrolled, as wide as the keel has room, starboard down: the course of midship, and what the "
    "hull swept, coloured where an alert held."
)
HISTORY = (
    "Water beside the hull, chances of contact, times to contact and to the last chance of the most likely run, "
    "and the rudder beside the one that holds the ship where it is; shaded where an alert held."
)


def write_transit_report(transit: WatchedTransit, path: str | Path) -> None:
    """Write one HTML file with a transit, its alerts, near misses and the rudder that it had left."""
    margin = transit.to_dict()["least_rudder_margin"]
    page = render(
        "transit.html.j2",
        title=": a transit of ".join(transit.names),
        said=transit.summary().splitlines(),
        margin=None if margin is None or not math.isfinite(margin) else f"{math.degrees(margin):.0f}",
        track=figure(transit_track_figure(transit), TRACK) if transit.located.any() else None,
        figure=figure(transit_figure(transit), HISTORY),
        alerts=[(f"{said.t:.0f}", said.alert) for said in transit.alerts],
        notes=transit.notes,
    )
    write_whole(path, page)
