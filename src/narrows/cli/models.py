"""``scale``, ``export``, ``ships`` and ``estimate``: scale, export, list and estimate models."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import click

import narrows as nw
from narrows.base.errors import InputError
from narrows.cli.options import Argument, AsJson, Delivery, ModelFile, Option, PlainModelDelivery, Speed, verb
from narrows.cli.voyages import OF_WATERWAY, HelmOptions, PhysicsOptions, WaterOptions
from narrows.empirical.fleet import model_named, table_of_ships
from narrows.export.exporters import EXPORTERS

*_FIRST, _LAST = map(repr, EXPORTERS)
WHAT = f"What to write: {', '.join(_FIRST)} or {_LAST}."
*_FIRST, _LAST = dict.fromkeys(suffix for exporter in EXPORTERS.values() for suffix in exporter.suffixes)
WHERE = f"File to write: {', '.join(_FIRST)} or {_LAST}."
MODEL_TO_SHOW = "Model to show: a model file, or the name of a published model."


@verb("narrows scale mikkelsen2025_dtc --length 355 --density 1025 --depth 24 -o full.toml")
def scale(
    model: ModelFile,
    length: Annotated[float, "Length between perpendiculars of the new ship [m]."],
    delivery: PlainModelDelivery,
    density: Annotated[float | None, "Density of the new water [kg/m3]; default: unchanged."] = None,
    width: Annotated[float | None, "Width of the new canal [m]; default: that of the tests, scaled."] = None,
    depth: Annotated[float | None, "Depth of the new canal [m]; default: that of the tests, scaled."] = None,
    form_factor: Annotated[float | None, "Scale friction by the ITTC line with this form factor k."] = None,
) -> None:
    """Scale a model to another length by Froude's law.

    It reports the effects that do not scale.

    MODEL is a model file, or the name of a published model.
    """
    from narrows.report.printed_tables import print_scaled

    scaled = nw.scale_model(model_named(model), length, density, width, depth, form_factor)
    delivery.write(scaled.model.save)
    delivery.show(scaled.to_dict, lambda: print_scaled(scaled))


@verb("narrows export c mikkelsen2025_dtc -o dtc.h", needs=OF_WATERWAY)
def export(
    kind: Annotated[str, Argument(help=WHAT)],
    model: ModelFile,
    output: Annotated[Path, Option("--output", "-o", help=WHERE)],
    physics: PhysicsOptions,
    water: WaterOptions,
    fmi: Annotated[int, "FMI version of an FMU: 2 or 3."] = 2,
    hold: Annotated[float | None, "Offset [m] held by a helm in the file."] = None,
    json: AsJson = False,
) -> None:
    """Export a model: C, C++, JavaScript, MATLAB, FMU and more.

    The file contains the equations of the simulation.

    MODEL is a model file, or the name of a published model.
    """
    from narrows.simulation.initial_state import voyage_defaults

    if kind not in EXPORTERS:
        kinds = ", ".join(f"{name} ({' '.join(own.suffixes)})" for name, own in EXPORTERS.items())
        raise InputError(f"there is no kind {kind!r}; choose {kinds}: the suffix of -o chooses the language")
    exporter = EXPORTERS[kind]
    ship, way = model_named(model), water.read()
    options: dict[str, Any] = {"waterway": way, "fmi": fmi, **vars(physics)}
    options["controller"] = HelmOptions(hold=hold).of(ship, voyage_defaults(ship).speed, 0.0, way)
    for name, why in exporter.refused.items():
        if options[name] is not None:
            raise InputError(why)
    known = exporter.options
    if hold is not None and "controller" not in known:
        raise InputError(f"a file of kind {kind} has no helm of its own to set; leave --hold out")
    written = exporter.write(ship, output, **{name: value for name, value in options.items() if name in known})
    notes, platforms = list(exporter.notes(written)), written if exporter.platforms else ()
    shown = {"summary": f"wrote {output}", "kind": kind, "output": str(output), "platforms": platforms, "notes": notes}
    Delivery(output, json).show(lambda: shown, lambda: click.echo("\n".join(notes), nl=bool(notes)))


@dataclass(frozen=True)
class DimensionOptions:
    length: Annotated[float, "Length between perpendiculars [m]."]
    width: Annotated[float, "Width of the canal, from bank to bank [m]."]
    depth: Annotated[float | None, "Depth of the canal [m]; default: deep water."] = None
    beam: Annotated[float | None, "Beam of the ship [m]; usual for its --type unless given."] = None
    draft: Annotated[float | None, "Draft of the ship [m]; usual for its --type unless given."] = None
    block: Annotated[float | None, "Block coefficient; usual for its --type unless given."] = None
    density: Annotated[float, "Density of the water [kg/m3]."] = 1025.0
    name: Annotated[str, "Name of the ship."] = "ship"


@verb("narrows estimate --length 366 --beam 51 --draft 15 --block 0.65 --width 300 --depth 18 -o ship.toml")
def estimate(
    dimensions: DimensionOptions,
    delivery: PlainModelDelivery,
    kind: Annotated[str | None, Option("--type", help="container, tanker, bulk, general, inland or convoy.")] = None,
    speed: Annotated[Speed | None, "Service speed: 12m/s, 16kn; default: usual for the type."] = None,
) -> None:
    """Estimate a model from the main dimensions of a ship.

    Its uncertainty is the error of the formulas on known ships.
    """
    from narrows.report.printed_tables import estimate_summary, print_estimate

    own = dimensions
    ship = {
        "length": own.length, "beam": own.beam, "draft": own.draft, "block_coefficient": own.block, "name": own.name,
    }  # fmt: skip
    model = nw.estimate_model(ship, nw.Canal(own.width, own.depth), nw.Water(own.density), kind=kind, speed=speed)
    delivery.write(model.save)
    delivery.show(lambda: estimate_summary(model), lambda: print_estimate(model))


@verb("narrows ships")
def ships(model: Annotated[str | None, Argument(help=MODEL_TO_SHOW)] = None, json: AsJson = False) -> None:
    """List the available ships, or show one model.

    Each name of the list replaces a model file.
    """
    from narrows.report.printed_tables import print_model, print_ships

    one = model_named(model) if model is not None else None
    table = nw.ready_ships() if model is None else table_of_ships([model])
    summary = one.summary() if one else f"{len(table)} ships; each name replaces a model file"
    notes = list(one.notes) if one else []
    shown = {"ships": table.reset_index().to_dict("records"), "summary": summary, "notes": notes}
    Delivery(json=json).show(lambda: shown, lambda: print_model(one) if one else print_ships(table))
