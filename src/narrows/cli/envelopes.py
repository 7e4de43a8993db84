"""``envelope``: how fast and how far off the middle a ship is still in hand."""

import sys
from typing import Annotated

import typer

from narrows.cli.delivery import DatasetDelivery
from narrows.cli.envelope_options import CaseOptions, GridOptions, ReserveOptions, SectionOptions, WeatherOptions
from narrows.cli.grouped import verb
from narrows.cli.options import ModelFile


@verb("narrows envelope full.toml --speed 4kn:12kn:17 --plot chart.png -o envelope.nc")
def envelope(
    model: ModelFile,
    grid: GridOptions,
    section: SectionOptions,
    weather: WeatherOptions,
    reserves: ReserveOptions,
    cases: CaseOptions,
    delivery: DatasetDelivery,
    controller: Annotated[
        str, typer.Option(help="Who is tried: regulator, human or track (that of earlier versions).")
    ] = "regulator",
    bank: Annotated[
        str, typer.Option(help="Kind of bank, for the rules of designers: gentle, sloping or steep.")
    ] = "steep",
    rudder_of: Annotated[
        str | None, typer.Option(help="Model whose rudder this one borrows, where it has none of its own.")
    ] = None,
) -> None:
    """Find how fast and how far off the middle of its canal a ship is still in hand, as a table and a chart.

    MODEL is a model file at the ship's own size, with the terms of a rudder (see scale, and docs/safe-envelope.md).
    """
    from narrows.model.model_file import model_named
    from narrows.model.rudder_transfer import borrow_rudder
    from narrows.report.envelope_chart import envelope_chart
    from narrows.report.envelope_table import print_envelope
    from narrows.safety import safe_envelope

    section.check()
    disturbance, ship = weather.disturbance(), model_named(model)
    ship = borrow_rudder(ship, model_named(rudder_of)) if rudder_of else ship
    ship, walls, where = section.placed(ship)
    result = safe_envelope(
        ship, grid.offsets, grid.speeds, disturbance=disturbance, **vars(reserves), **vars(cases), walls=walls,
        bank=bank, controller=controller, progress=sys.stderr.isatty() and not delivery.json,
    )  # fmt: skip
    result = result.noting(where) if where else result
    delivery.write(result.save, lambda: envelope_chart(result))
    delivery.tell(result.to_dict, lambda: print_envelope(result))
    raise SystemExit(int(bool(result.highest_speed().isnull().all())))
