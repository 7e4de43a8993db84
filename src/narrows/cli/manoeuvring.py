"""``trials``: turning circles and zigzags in open water."""

from typing import Annotated

import typer

from narrows.cli.app import app
from narrows.cli.options import AsJson, ModelFile, Plot, TableOutput
from narrows.cli.output import print_json, say_written


@app.command(epilog="Example: narrows trials yasukawa2015_kvlcc2 --speed 1.179m/s --plot tracks.png")
def trials(
    model: ModelFile,
    speed: Annotated[str, typer.Option(help="Of the approach: 1.2m/s, 8kn; m/s without a unit.")],
    turn_deg: Annotated[float, typer.Option(help="Rudder of the turning circles, to either side [deg].")] = 35.0,
    zigzags: Annotated[str, typer.Option(help="Rudder/heading of the zigzags [deg], a/b,c/d.")] = "10/10,20/20",
    dt: Annotated[float | None, typer.Option(help="Time step [s]; a 120th of the time for a ship length.")] = None,
    output: TableOutput = None,
    plot: Plot = None,
    json: AsJson = False,
) -> None:
    """Turn circles and sail zigzags in open water: advance, tactical diameter, overshoots.

    MODEL is a model file with the terms of a rudder, or the name of a published model. Terms of the banks are left out.
    """
    from narrows.cli.ranges import speed as read_speed
    from narrows.manoeuvres.manoeuvring_trials import parse_zigzags, sail_trials
    from narrows.model.model_file import model_named
    from narrows.report.manoeuvre_report import manoeuvres_figure, print_manoeuvres

    result = sail_trials(model_named(model), read_speed("--speed", speed), turn_deg, parse_zigzags(zigzags), dt)
    if output:
        result.save(output)
    if plot:
        from narrows.files import save_figure

        save_figure(manoeuvres_figure(result), plot)
    print_json(result.to_dict()) if json else print_manoeuvres(result)
    say_written((output, plot), json)
