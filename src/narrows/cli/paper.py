"""``reproduce``: the paper, ours beside its own."""

from pathlib import Path
from typing import Annotated, Any

import typer

from narrows.cli.app import app
from narrows.cli.options import AsJson
from narrows.cli.output import folder, print_json


@app.command(epilog="Example: narrows reproduce --out paper")
def reproduce(
    out: Annotated[Path, typer.Option(help="Folder for report.html.")] = Path("out"),
    json: AsJson = False,
) -> None:
    """Make every table and figure of the paper again, ours beside its own numbers."""
    from narrows.report.paper import write_reproduction

    folder(out)
    numbers = write_reproduction(out / "report.html", lambda doing: typer.echo(f"{doing} ...", err=True))
    summary = "\n".join(_said(reading) for reading in numbers["readings"])
    if json:
        print_json({**numbers, "summary": summary, "notes": []})
        return
    typer.echo(summary)
    typer.echo(f"wrote {out / 'report.html'}")


def _said(reading: dict[str, Any]) -> str:
    where = "nowhere" if reading["switch"] is None else f"from y(0) = {reading['switch']:.2f} m"
    return f"grounds on the near bank {where}: {reading['name']}"
