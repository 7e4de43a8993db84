"""A watched transit as one self-contained page, for training and for investigation."""

import math
from pathlib import Path

from narrows.files import write_whole
from narrows.report.fit_page import figure, render
from narrows.report.transit_figures import transit_figure
from narrows.warning.monitoring.watched_transit import WatchedTransit


def write_transit_report(transit: WatchedTransit, path: str | Path) -> None:
    """Write one HTML file with a transit, its alerts, near misses and the rudder that it had left.

    Parameters
    ----------
    transit : WatchedTransit
        What was said of it.
    path : str or Path
        Where to.

    Raises
    ------
    InputError
        Where the file cannot be written.
    """
    caption = (
        "Water beside the hull, chances of contact, times to contact and to the last chance of the most likely run, "
        "and the rudder beside the one that holds the ship where it is; shaded where an alert held."
    )
    margin = transit.to_dict()["least_rudder_margin"]
    page = render(
        "transit.html.j2",
        title=f"{transit.ship}: a transit of {transit.waterway}",
        said=transit.summary().splitlines(),
        margin=None if margin is None or not math.isfinite(margin) else f"{math.degrees(margin):.0f}",
        figure=figure(transit_figure(transit), caption),
        alerts=[(f"{said.t:.0f}", said.alert) for said in transit.alerts],
        notes=transit.notes,
    )
    write_whole(path, page)
