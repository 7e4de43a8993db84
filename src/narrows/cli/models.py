"""``scale``: a model at full size."""

from pathlib import Path
from typing import Annotated

import typer

from narrows.cli.app import app
from narrows.cli.options import AsJson, ModelFile, ModelOutput, verb
from narrows.cli.output import print_json, say_written
from narrows.cli.voyage_options import PhysicsOptions, WaterOptions
from narrows.errors import InputError, check_choice


@app.command(epilog="Example: narrows scale mikkelsen2025_dtc --length 355 --density 1025 --depth 24 -o full.toml")
def scale(
    model: ModelFile,
    length: Annotated[float, typer.Option(help="Between perpendiculars, of the new ship [m].")],
    density: Annotated[float | None, typer.Option(help="Of the new water [kg/m3]; as it was unless given.")] = None,
    width: Annotated[float | None, typer.Option(help="Of the new canal [m]; the tests' scaled unless given.")] = None,
    depth: Annotated[float | None, typer.Option(help="Of the new canal [m]; the tests' scaled unless given.")] = None,
    form_factor: Annotated[float | None, typer.Option(help="Scale friction by the ITTC's line with this k.")] = None,
    wetted_surface: Annotated[float | None, typer.Option(help="Of the old hull [m2], with --form-factor.")] = None,
    at_speed: Annotated[str | None, typer.Option(help="Of the old hull: 1.2m/s, 2kn; with --form-factor.")] = None,
    output: ModelOutput = None,
    json: AsJson = False,
) -> None:
    """Scale a model to another length by Froude's law, and say what does not scale.

    MODEL is a model file, or the name of a published model.
    """
    from narrows.model.froude import Friction, scale_model
    from narrows.model.model_file import model_named, save_model
    from narrows.report.printed_tables import print_scaled

    friction = None
    if form_factor is None and not (wetted_surface is None and at_speed is None):
        raise InputError("--wetted-surface and --at-speed serve --form-factor; add it, or leave them out")
    if form_factor is not None:
        if wetted_surface is None or at_speed is None:
            raise InputError("--form-factor needs --wetted-surface and --at-speed of the old hull; add them")
        from narrows.cli.options import speed

        friction = Friction(wetted_surface, form_factor, speed("--at-speed", at_speed))
    old = model_named(model)
    scaled = scale_model(old, length, density, width, depth, friction)
    if output:
        save_model(scaled.model, output)
    if json:
        print_json(scaled.to_dict())
        return
    print_scaled(scaled)
    say_written([output])


SOURCES_ALONE = "no compiler is here: the FMU has its sources alone, which importers may compile"
KINDS = ("c", "js", "python", "latex", "fmu", "page")


@verb("narrows export c mikkelsen2025_dtc -o dtc.h")
def export(
    kind: Annotated[
        str, typer.Argument(help="What to write: 'c', 'js', 'python', 'latex', 'fmu' or 'page'.", show_default=False)
    ],
    model: ModelFile,
    output: Annotated[Path, typer.Option("--output", "-o", help="File to write: .h, .mjs, .py, .tex, .fmu or .html.")],
    physics: PhysicsOptions,
    water: WaterOptions,
    fmi: Annotated[int, typer.Option(help="Of an FMU, the version of the standard: 2 or 3.")] = 2,
    json: AsJson = False,
) -> None:
    """Write a model as a file of another language, printed from the lines that voyages are sailed by.

    MODEL is a model file, or the name of a published model.
    """
    from narrows import export as room
    from narrows.export.fmu import lacks_zig
    from narrows.model.model_file import model_named

    check_choice("what to export", kind, KINDS)
    platforms: tuple[str, ...] = ()
    notes: list[str] = []
    if kind == "latex":
        room.write_latex(model_named(model), output)
    elif kind == "fmu":
        platforms = room.write_fmu(model_named(model), output, fmi=fmi, waterway=water.read(), **vars(physics))
    elif kind == "page":
        if water.read() is not None:
            raise InputError("a page shows a straight canal; leave --waterway out")
        notes += room.write_page(model_named(model), output, **vars(physics))
    else:
        write = {"c": room.write_c, "js": room.write_javascript, "python": room.write_python}[kind]
        write(model_named(model), output, waterway=water.read(), **vars(physics))
    if kind == "fmu":
        notes = [f"libraries for {', '.join(platforms)}" if platforms else SOURCES_ALONE]
        notes += filter(None, [lacks_zig()])
    if json:
        summary = f"wrote {output}"
        print_json({"summary": summary, "kind": kind, "output": str(output), "platforms": platforms, "notes": notes})
        return
    for note in notes:
        typer.echo(note)
    say_written([output])
