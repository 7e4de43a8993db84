"""``waterway``: look at a waterway, or measure one in an electronic chart."""

from pathlib import Path
from typing import Annotated

from narrows.cli.declarations import Argument, Option
from narrows.cli.options import AsJson, WaterwayOutput, verb
from narrows.cli.output import print_json, say_written
from narrows.errors import InputError

# How far off a bank of a chart is looked for [m].
REACH = 1000.0


@verb("narrows waterway --line axis.geojson --width 300 --depth 16 -o canal.geojson")
def waterway(
    file: Annotated[
        Path | None, Argument(help="GeoJSON, or a cell of an electronic chart (.000); none with --width and --depth.")
    ] = None,
    line: Annotated[
        Path | None,
        Option(help="Centreline, for a chart or with --width and --depth: GeoJSON with a LineString, as it is sailed."),
    ] = None,
    width: Annotated[float | None, Option(help="From bank to bank along --line [m].")] = None,
    depth: Annotated[float | None, Option(help="Of the water along --line [m].")] = None,
    reach: Annotated[float, Option(help="How far off a bank is looked for in a chart [m].")] = REACH,
    draft: Annotated[float, Option(help="Of a ship [m]: the width is then where the keel has room.")] = 0.0,
    output: WaterwayOutput = None,
    json: AsJson = False,
) -> None:
    """Make a waterway, or check one: from a line with a width and a depth, from a chart, or from its GeoJSON."""
    from narrows.report.printed_tables import print_waterway, waterway_summary
    from narrows.waterway import read_waterway, write_waterway
    from narrows.waterway.geojson import read_line, waterway_from_line

    _check_together(file, line, width is not None or depth is not None, reach)
    if not 0 <= draft < 1000:
        raise InputError(f"--draft {draft} is no draft; give metres from 0")
    if file is None:
        if line is None or width is None or depth is None:
            raise InputError("give a file, or --line axis.geojson --width 300 --depth 16 to make a canal of one width")
        result = waterway_from_line(read_line(line), width, depth, line.stem)
    elif line is None:
        result = read_waterway(file)
    else:
        from narrows.waterway.from_chart import read_chart, waterway_from_chart

        result = waterway_from_chart(read_chart(file), read_line(line), reach)
    if output:
        write_waterway(result, output)
    if json:
        print_json(waterway_summary(result, draft))
        return
    print_waterway(result, draft)
    say_written([output])


def _check_together(file: Path | None, line: Path | None, sized: bool, reach: float) -> None:
    """Raise where arguments contradict each other."""
    if file is not None and sized:
        raise InputError("--width and --depth make a waterway along --line alone; leave them out, or the file")
    if file is not None and (file.suffix == ".000") != (line is not None):
        raise InputError("a chart (.000) goes with --line, its centreline as GeoJSON; a GeoJSON waterway goes without")
    if (line is None or file is None) and reach != REACH:
        raise InputError("--reach measures a chart; leave it out for a GeoJSON waterway")
