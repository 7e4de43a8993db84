"""``waterway``: look at a waterway, or measure one in an electronic chart."""

from pathlib import Path
from typing import Annotated

import typer

from narrows.cli.app import app
from narrows.cli.options import AsJson
from narrows.cli.output import print_json
from narrows.errors import InputError

REACH = 1000.0
"""How far off a bank of a chart is looked for [m]."""


@app.command(epilog="Example: narrows waterway 1W7RH001.000 --line axis.geojson -o canal.geojson")
def waterway(
    file: Annotated[Path, typer.Argument(help="GeoJSON, or a cell of an electronic chart (.000).", show_default=False)],
    line: Annotated[
        Path | None, typer.Option(help="Centreline for a chart: GeoJSON with a LineString, as she sails it.")
    ] = None,
    spacing: Annotated[float | None, typer.Option(help="Between stations in a chart [m].")] = None,
    reach: Annotated[float, typer.Option(help="How far off a bank is looked for in a chart [m].")] = REACH,
    draft: Annotated[float, typer.Option(help="Of a ship [m]: the width is then where her keel has room.")] = 0.0,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="GeoJSON to write.")] = None,
    json: AsJson = False,
) -> None:
    """Check a waterway and say how long, wide and deep it is; from a chart, measure it along a centreline."""
    from narrows.report.waterway_table import print_waterway, waterway_summary
    from narrows.waterway import read_waterway, write_waterway

    if (file.suffix == ".000") != (line is not None):
        raise InputError("a chart (.000) goes with --line, its centreline as GeoJSON; a GeoJSON waterway goes without")
    if line is None and (spacing is not None or reach != REACH):
        raise InputError("--spacing and --reach measure a chart; leave them out for a GeoJSON waterway")
    if not 0 <= draft < 1000:
        raise InputError(f"--draft {draft} is no draft; give metres from 0")
    if line is None:
        found = read_waterway(file)
    else:
        from narrows.waterway.chart import read_chart
        from narrows.waterway.from_chart import waterway_from_chart
        from narrows.waterway.geojson import read_line

        found = waterway_from_chart(read_chart(file), read_line(line), spacing, reach)
    if output:
        write_waterway(found, output)
    if json:
        print_json(waterway_summary(found, draft))
        return
    print_waterway(found, draft)
    if output:
        typer.echo(f"wrote {output}")
