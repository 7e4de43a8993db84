"""``plan``: the tests to run next."""

from pathlib import Path
from typing import Annotated

import typer

from narrows.cli.app import app
from narrows.cli.options import AsJson, TermsName
from narrows.cli.output import print_json


@app.command(epilog="Example: narrows plan ship.toml --runs 12 --speed 0.6m/s,0.9m/s -o runs.csv")
def plan(
    ship: Annotated[Path, typer.Argument(help="Ship file: TOML with [ship], [canal], [water].", show_default=False)],
    runs: Annotated[int, typer.Option(help="How many runs there is time for.")] = 12,
    run_length: Annotated[float | None, typer.Option(help="Of steady motion in one run [m]; 10 ship lengths.")] = None,
    clearance: Annotated[float, typer.Option(help="Least distance from the hull's side to a wall, in beams.")] = 1.5,
    speed: Annotated[
        str | None, typer.Option(help="To run at: 0.6m/s,0.9m/s or from:to:count; three slow ones unless given.")
    ] = None,
    depths: Annotated[
        str | None, typer.Option(help="To run at [m]: a,b,c or from:to:count; for terms that know the depth.")
    ] = None,
    terms: TermsName = "paper",
    targets: Annotated[str, typer.Option(help="Coefficients that matter, a,b,c; the bank's unless given.")] = "",
    criterion: Annotated[str, typer.Option(help="'c': sum of the variances; 'd': determinant.")] = "c",
    after: Annotated[Path | None, typer.Option(help="Captive tests that were made already.")] = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="CSV file of the runs to write.")] = None,
    json: AsJson = False,
) -> None:
    """Propose the captive tests that make the bank's coefficients best known."""
    from narrows.captive import read_captive
    from narrows.cli.ranges import numbers, speeds
    from narrows.experiment_design import Tank, plan_tests
    from narrows.report.plan_table import print_plan, write_plan
    from narrows.ship.ship_file import read_ship
    from narrows.terms.tables import table_named

    chosen = table_named(terms)
    at_speeds = () if speed is None else tuple(speeds("--speed", speed).tolist())
    at_depths = () if depths is None else tuple(numbers("--depths", depths).tolist())
    tank = Tank(run_length, clearance, speeds=at_speeds, depths=at_depths)
    made = read_captive(after, ship, chosen) if after else None
    found = plan_tests(
        read_ship(ship), runs, tank=tank, terms=chosen, targets=tuple(filter(None, targets.split(","))),
        criterion=criterion, after=made,
    )  # fmt: skip
    if output:
        write_plan(found, output)
    if json:
        print_json(found.to_dict())
    else:
        print_plan(found)
        if output:
            typer.echo(f"wrote {output}")
    if not found.determined:
        raise SystemExit(1)
