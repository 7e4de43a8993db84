"""``envelope``: how fast and how far off the middle a ship is still in hand."""

import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from narrows.cli.app import app
from narrows.cli.options import AsJson, DatasetOutput, ModelFile, Plot
from narrows.cli.output import print_json, say_written
from narrows.errors import InputError

if TYPE_CHECKING:
    from narrows.model.model import Model


@app.command(epilog="Example: narrows envelope full.toml --speed 4kn:12kn:17 --plot chart.png -o envelope.nc")
def envelope(
    model: ModelFile,
    y: Annotated[
        str | None,
        typer.Option(help="From the middle [m]: a number, a,b,c or from:to:count; bank to bank unless given."),
    ] = None,
    speed: Annotated[
        str | None, typer.Option(help="Through the water: 8kn, 4kn:12kn:17, 4.1m/s; to choking unless given.")
    ] = None,
    controller: Annotated[
        str, typer.Option(help="Who is tried: regulator, human or track (that of earlier versions).")
    ] = "regulator",
    bank: Annotated[
        str, typer.Option(help="Kind of bank, for the rules of designers: gentle, sloping or steep.")
    ] = "steep",
    rudder_of: Annotated[
        str | None, typer.Option(help="Model whose rudder this one borrows, where it has none of its own.")
    ] = None,
    waterway: Annotated[
        Path | None, typer.Option(help="GeoJSON of a waterway, whose section takes the place of the model's canal.")
    ] = None,
    at: Annotated[float, typer.Option(help="Where along the waterway [m].")] = 0.0,
    level: Annotated[float, typer.Option(help="Of its water over that of its depths [m].")] = 0.0,
    heading_deg: Annotated[float, typer.Option(help="Heading off at the start, standard deviation [deg].")] = 2.0,
    wind: Annotated[str, typer.Option(help="Speed of a beam gust, from either side: 20m/s, 40kn.")] = "0m/s",
    windage: Annotated[float, typer.Option(help="Lateral area above the water [m2], with --wind.")] = 0.0,
    gust_lever: Annotated[float, typer.Option(help="Of the gust, forward of midship [m].")] = 0.0,
    gust_time: Annotated[float, typer.Option(help="How long the gust lasts [s].")] = 60.0,
    reserve: Annotated[float, typer.Option(help="Share of the rudder to be left on the steady course.")] = 1 / 3,
    keel: Annotated[
        float | None, typer.Option(help="Least water under the keel [m]; a twentieth of the draft.")
    ] = None,
    most_revolutions: Annotated[
        float | None, typer.Option(help="Of the engine [1/s], for a model with a propeller.")
    ] = None,
    samples: Annotated[
        int | None,
        typer.Option(help="Of coefficients and disturbances; as many as settle the edge to a step unless given."),
    ] = None,
    seed: Annotated[int, typer.Option(help="Of the samples.")] = 0,
    output: DatasetOutput = None,
    plot: Plot = None,
    json: AsJson = False,
) -> None:
    """Find how fast and how far off the middle of its canal a ship is still in hand, as a table and a chart.

    MODEL is a model file at the ship's own size, with the terms of a rudder (see scale, and docs/safe-envelope.md).
    """
    from narrows.cli.ranges import numbers, speeds
    from narrows.cli.ranges import speed as read_speed
    from narrows.model.model_file import model_named
    from narrows.model.rudder_transfer import borrow_rudder
    from narrows.report.envelope_table import print_envelope
    from narrows.safety import Disturbance, safe_envelope, wind_force

    if waterway is None and (at or level):
        raise InputError("--at and --level are a waterway's; add --waterway, or leave them out")
    gust = read_speed("--wind", wind)
    if bool(gust) != bool(windage):
        raise InputError("a gust needs both --wind and --windage; give both, or neither")
    ship = model_named(model)
    ship = borrow_rudder(ship, model_named(rudder_of)) if rudder_of else ship
    ship, walls, where = _placed(ship, waterway, at, level) if waterway else (ship, None, "")
    disturbance = Disturbance(
        heading_deg, gust=wind_force(gust, windage), gust_lever=gust_lever, gust_time=gust_time, wind=gust or None
    )
    result = safe_envelope(
        ship,
        None if y is None else numbers("--y", y),
        None if speed is None else speeds("--speed", speed),
        disturbance=disturbance, reserve=reserve, keel=keel, most_revolutions=most_revolutions,
        samples=samples, seed=seed, walls=walls, bank=bank, controller=controller,
        progress=sys.stderr.isatty() and not json,
    )  # fmt: skip
    if where:
        result = result.noting(where)
    if output:
        result.save(output)
    if plot:
        from narrows.files import save_figure
        from narrows.report.envelope_chart import envelope_chart

        save_figure(envelope_chart(result), plot)
    print_json(result.to_dict()) if json else print_envelope(result)
    say_written((output, plot), json)
    raise SystemExit(int(bool(result.highest_speed().isnull().all())))


def _placed(model: "Model", file: Path, at: float, level: float) -> "tuple[Model, tuple[float, float], str]":
    """The model in the section of a waterway at a place; where its keel meets its banks, and where its middle is."""
    from narrows.waterway import read_waterway

    waterway, ship = read_waterway(file).with_water(level=level), model.configuration.ship
    if not 0 <= at <= waterway.line.length:
        raise InputError(f"--at {at:g} is beyond the waterway, which is {waterway.line.length:.0f} m long")
    waterway.check_fits(ship, at)
    canal, middle, room = waterway.canal(at), float(waterway.section(at).middle), waterway.room(at, ship.draft)
    canal = canal if canal.depth else replace(canal, depth=model.configuration.canal.depth)
    aside, half = float(room.middle) - middle, float(room.width) / 2
    sentence = (
        f"at {at:.0f} m along {waterway.name}: the middle is {middle:+.1f} m off its centreline, starboard positive"
    )
    return (
        replace(model, configuration=replace(model.configuration, canal=canal)),
        (half - aside, half + aside),
        sentence,
    )
