"""``export``: a model out of Python."""

from pathlib import Path
from typing import Annotated

import typer

from narrows.cli.options import AsJson, ModelFile, verb
from narrows.cli.output import print_json, say_written
from narrows.cli.voyage_options import PhysicsOptions, WaterOptions
from narrows.errors import InputError, check_choice

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
    from narrows.export.native_builds import lacks_zig
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
