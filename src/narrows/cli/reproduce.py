"""``reproduce``: the paper, ours beside its own."""

from pathlib import Path
from typing import Annotated

import typer

from narrows.cli.app import app
from narrows.cli.options import AsJson
from narrows.cli.output import folder, print_json


@app.command(epilog="Example: narrows reproduce -o paper")
def reproduce(
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for report.html.")] = Path("out"),
    json: AsJson = False,
) -> None:
    """Make every table and figure of the paper again, ours beside its own numbers."""
    from narrows.report.reproduction import write_reproduction
    from narrows.studies.mikkelsen2025 import reproduce as made

    folder(out)
    result = made(lambda doing: typer.echo(f"{doing} ...", err=True))
    typer.echo("figures ...", err=True)
    write_reproduction(result, out / "report.html")
    if json:
        print_json(result.to_dict())
    else:
        typer.echo(f"{result.summary()}\nwrote {out / 'report.html'}")
