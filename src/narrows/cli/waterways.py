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
        Path | None,
        Argument(help="GeoJSON, KML, shapefile, or a cell of an electronic chart (.000); none with --width."),
    ] = None,
    line: Annotated[
        Path | None,
        Option(help="Centreline, through a chart or an area, or with --width: a map with one line, as it is sailed."),
    ] = None,
    width: Annotated[float | None, Option(help="From bank to bank along --line [m].")] = None,
    depth: Annotated[float | None, Option(help="Of the water [m], where the file gives none.")] = None,
    reach: Annotated[float, Option(help="How far off a bank is looked for in a chart [m].")] = REACH,
    draft: Annotated[float, Option(help="Of a ship [m]: the width is then where the keel has room.")] = 0.0,
    output: WaterwayOutput = None,
    json: AsJson = False,
) -> None:
    """Make a waterway, or check one: from a line with a width and a depth, from a chart, or from its GeoJSON."""
    from narrows.report.printed_tables import print_waterway, waterway_summary
    from narrows.waterway import read_waterway, write_waterway
    from narrows.waterway.geojson import read_line, waterway_from_line, with_depth

    _check_together(file, line, width, reach)
    if not 0 <= draft < 1000:
        raise InputError(f"--draft {draft} is no draft; give metres from 0")
    if file is None:
        if line is None or width is None or depth is None:
            raise InputError("give a file, or --line axis.geojson --width 300 --depth 16 to make a canal of one width")
        result = waterway_from_line(read_line(line), width, depth, line.stem)
    elif line is None:
        result = read_waterway(file) if depth is None else with_depth(read_waterway(file), depth)
    else:
        from narrows.waterway.from_chart import chart_of_area, read_chart, waterway_from_chart

        of_chart = file.suffix == ".000"
        if not of_chart and depth is None:
            raise InputError(f"{file} gives no depth; add --depth 16")
        chart = read_chart(file) if of_chart else chart_of_area(file, depth or 0.0)
        result = waterway_from_chart(chart, read_line(line), reach)
    if output:
        write_waterway(result, output)
    if json:
        print_json(waterway_summary(result, draft))
        return
    print_waterway(result, draft)
    say_written([output])


def _check_together(file: Path | None, line: Path | None, width: float | None, reach: float) -> None:
    """Raise where arguments contradict each other."""
    if file is not None and width is not None:
        raise InputError("--width makes a waterway along --line alone; leave it out, or the file")
    if file is not None and file.suffix == ".000" and line is None:
        raise InputError("a chart (.000) goes with --line, its centreline on a map with one line")
    if (line is None or file is None) and reach != REACH:
        raise InputError("--reach measures a chart or an area; leave it out for banks that are drawn")
