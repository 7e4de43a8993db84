"""``design``: the tests to run next."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from narrows.cli.app import app
from narrows.cli.options import AsJson, TermsName
from narrows.cli.output import numbers, print_json

if TYPE_CHECKING:
    pass


@app.command(epilog="Example: narrows design ship.toml --runs 12 --speeds 0.6,0.9 -o runs.csv")
def design(
    ship: Annotated[Path, typer.Argument(help="Ship file: TOML with [ship], [canal], [water].", show_default=False)],
    runs: Annotated[int, typer.Option(help="How many runs there is time for.")] = 12,
    run_length: Annotated[float | None, typer.Option(help="Of steady motion in one run [m]; 10 ship lengths.")] = None,
    clearance: Annotated[float, typer.Option(help="Least distance from the hull's side to a wall, in beams.")] = 1.5,
    speeds: Annotated[str, typer.Option(help="To run at [m/s], a,b,c; three slow ones unless given.")] = "",
    depths: Annotated[str, typer.Option(help="To run at [m], a,b,c; for terms that know the depth.")] = "",
    terms: TermsName = "paper",
    targets: Annotated[str, typer.Option(help="Coefficients that matter, a,b,c; the bank's unless given.")] = "",
    criterion: Annotated[str, typer.Option(help="'c': sum of the variances; 'd': determinant.")] = "c",
    after: Annotated[Path | None, typer.Option(help="Captive tests that were made already.")] = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="CSV file of the runs to write.")] = None,
    json: AsJson = False,
) -> None:
    """Propose the captive tests that make the bank's coefficients best known."""
    from narrows.captive import read_captive
    from narrows.experiment_design import Tank, plan_tests
    from narrows.report.plan_table import print_plan, write_plan
    from narrows.ship.ship_file import read_ship
    from narrows.terms.tables import table_named

    chosen = table_named(terms)
    tank = Tank(run_length, clearance, speeds=numbers(speeds, "--speeds"), depths=numbers(depths, "--depths"))
    made = read_captive(after, ship, chosen) if after else None
    plan = plan_tests(
        read_ship(ship), runs, tank=tank, terms=chosen, targets=tuple(filter(None, targets.split(","))),
        criterion=criterion, after=made,
    )  # fmt: skip
    if output:
        write_plan(plan, output)
    if json:
        print_json(plan.to_dict())
    else:
        print_plan(plan)
        if output:
            typer.echo(f"wrote {output}")
    if not plan.determined:
        raise SystemExit(1)
