"""``reproduce``: the paper, ours beside its own."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from narrows.cli.app import app
from narrows.cli.options import AsJson
from narrows.cli.output import folder, print_json

if TYPE_CHECKING:
    pass


@app.command(epilog="Example: narrows reproduce --out paper")
def reproduce(
    out: Annotated[Path, typer.Option(help="Folder for report.html.")] = Path("out"),
    json: AsJson = False,
) -> None:
    """Make every table and figure of the paper again, ours beside its own numbers."""
    from narrows.report.paper import write_reproduction

    folder(out)
    numbers = write_reproduction(out / "report.html", lambda doing: typer.echo(f"{doing} ...", err=True))
    if json:
        print_json(numbers)
        return
    for reading in numbers["readings"]:
        where = "nowhere" if reading["switch"] is None else f"from y(0) = {reading['switch']:.2f} m"
        typer.echo(f"grounds on the near bank {where}: {reading['name']}")
    typer.echo(f"wrote {out / 'report.html'}")
