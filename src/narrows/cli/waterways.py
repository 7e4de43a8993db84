"""``waterway``: look at a waterway, or measure one in an electronic chart."""

from pathlib import Path
from typing import Annotated

from narrows.cli.declarations import Argument, Option
from narrows.cli.options import AsJson, WaterwayOutput, verb
from narrows.cli.output import print_json, say_written
from narrows.errors import InputError

# How far off a bank of a chart is looked for [m].
REACH = 1000.0


@verb("narrows waterway 1W7RH001.000 --line axis.geojson -o canal.geojson")
def waterway(
    file: Annotated[Path, Argument(help="GeoJSON, or a cell of an electronic chart (.000).")],
    line: Annotated[
        Path | None,
        Option(help="Centreline for a chart: GeoJSON with a LineString, as it is sailed."),
    ] = None,
    reach: Annotated[float, Option(help="How far off a bank is looked for in a chart [m].")] = REACH,
    draft: Annotated[float, Option(help="Of a ship [m]: the width is then where the keel has room.")] = 0.0,
    output: WaterwayOutput = None,
    json: AsJson = False,
) -> None:
    """Check a waterway and say how long, wide and deep it is; from a chart, measure it along a centreline."""
    from narrows.report.printed_tables import print_waterway, waterway_summary
    from narrows.waterway import read_waterway, write_waterway

    if (file.suffix == ".000") != (line is not None):
        raise InputError("a chart (.000) goes with --line, its centreline as GeoJSON; a GeoJSON waterway goes without")
    if line is None and reach != REACH:
        raise InputError("--reach measures a chart; leave it out for a GeoJSON waterway")
    if not 0 <= draft < 1000:
        raise InputError(f"--draft {draft} is no draft; give metres from 0")
    if line is None:
        result = read_waterway(file)
    else:
        from narrows.waterway.from_chart import read_chart, waterway_from_chart
        from narrows.waterway.geojson import read_line

        result = waterway_from_chart(read_chart(file), read_line(line), reach)
    if output:
        write_waterway(result, output)
    if json:
        print_json(waterway_summary(result, draft))
        return
    print_waterway(result, draft)
    say_written([output])
