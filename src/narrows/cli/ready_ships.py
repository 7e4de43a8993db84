"""``estimate`` and ``ships``: a model without tests, and the ships that are ready."""

from dataclasses import dataclass
from typing import Annotated

from narrows.cli.declarations import Option
from narrows.cli.options import AsJson, ModelOutput, verb
from narrows.cli.options import speed as read_speed
from narrows.cli.output import print_json, say_written


@dataclass(frozen=True)
class DimensionOptions:
    length: Annotated[float, Option(help="Between perpendiculars [m].")]
    width: Annotated[float, Option(help="Of the canal, from bank to bank [m].")]
    depth: Annotated[float | None, Option(help="Of the canal [m]; deep water unless given.")] = None
    beam: Annotated[float | None, Option(help="Of the ship [m]; usual for its --type unless given.")] = None
    draft: Annotated[float | None, Option(help="Of the ship [m]; usual for its --type unless given.")] = None
    block: Annotated[float | None, Option(help="Block coefficient; usual for its --type unless given.")] = None
    density: Annotated[float, Option(help="Of the water [kg/m3].")] = 1025.0
    name: Annotated[str, Option(help="Of the ship.")] = "ship"


@verb("narrows estimate --length 366 --beam 51 --draft 15 --block 0.65 --width 300 --depth 18 -o ship.toml")
def estimate(
    dimensions: DimensionOptions,
    kind: Annotated[str | None, Option("--type", help="container, tanker, bulk, general, inland or convoy.")] = None,
    speed: Annotated[str | None, Option(help="Service speed: 12m/s, 16kn; usual for the type if left out.")] = None,
    output: ModelOutput = None,
    json: AsJson = False,
) -> None:
    """Estimate a model from main dimensions, with the spread that the formulas show on known ships."""
    from narrows.empirical.main_dimensions import estimate_model
    from narrows.model.model_file import save_model
    from narrows.report.printed_tables import estimate_summary, print_estimate
    from narrows.ship.particulars import Canal, Water

    own = dimensions
    ship = {
        "length": own.length, "beam": own.beam, "draft": own.draft, "block_coefficient": own.block, "name": own.name,
    }  # fmt: skip
    service = None if speed is None else read_speed("--speed", speed)
    model = estimate_model(ship, Canal(own.width, own.depth), Water(own.density), kind=kind, speed=service)
    if output:
        save_model(model, output)
    if json:
        print_json(estimate_summary(model))
        return
    print_estimate(model)
    say_written([output])


@verb("narrows ships")
def ships(json: AsJson = False) -> None:
    """List the ships that are ready: each name goes wherever a model file does."""
    from narrows.empirical.fleet import ready_ships
    from narrows.report.printed_tables import print_ships

    table = ready_ships()
    if json:
        summary = f"{len(table)} ships; each name goes wherever a model file does"
        print_json({"ships": table.reset_index().to_dict("records"), "summary": summary, "notes": []})
        return
    print_ships(table)
