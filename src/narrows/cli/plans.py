"""``plan``: the tests to run next."""

from pathlib import Path
from typing import Annotated

import typer

from narrows.cli.app import app
from narrows.cli.options import AsJson, Condition, Mapping, TableOutput, TermsName, Where
from narrows.cli.output import print_json, say_written
from narrows.errors import InputError


@app.command(epilog="Example: narrows plan ship.toml --runs 12 --speed 0.6m/s,0.9m/s -o runs.csv")
def plan(
    ship: Annotated[Path, typer.Argument(help="Ship file: TOML with [ship], [canal], [water].", show_default=False)],
    runs: Annotated[int, typer.Option(help="How many runs there is time for.")] = 12,
    run_length: Annotated[float | None, typer.Option(help="Of steady motion in one run [m]; 10 ship lengths.")] = None,
    clearance: Annotated[float, typer.Option(help="Least distance from the hull's side to a wall, in beams.")] = 1.5,
    speed: Annotated[
        str | None,
        typer.Option(
            help="To run at: 0.6m/s,0.9m/s or from:to:count; those tested before, or three slow ones, unless given."
        ),
    ] = None,
    depths: Annotated[
        str | None, typer.Option(help="To run at [m]: a,b,c or from:to:count; for terms that know the depth.")
    ] = None,
    reach: Annotated[
        float | None, typer.Option(help="Farthest offset from the centreline [m]; within what was tested unless given.")
    ] = None,
    run_errors: Annotated[
        str, typer.Option(help="What runs differ by: gain, zero and form, as shares of the force.")
    ] = "0.02,0.02,0.02",
    terms: TermsName = "paper",
    targets: Annotated[str, typer.Option(help="Coefficients that matter, a,b,c; the bank's unless given.")] = "",
    criterion: Annotated[str, typer.Option(help="'c': sum of the variances; 'd': determinant.")] = "c",
    after: Annotated[Path | None, typer.Option(help="Captive tests that were made already.")] = None,
    where: Where = None,
    mapping: Mapping = None,
    condition: Condition = None,
    output: TableOutput = None,
    json: AsJson = False,
) -> None:
    """Propose the captive tests that make the bank's coefficients best known."""
    from narrows.captive import read_captive
    from narrows.cli.ranges import numbers, speeds
    from narrows.experiment_design import Tank, plan_tests
    from narrows.identification.conditions import the_condition
    from narrows.identification.uncertainty.run_errors import run_errors_of
    from narrows.report.plan_table import print_plan
    from narrows.terms.tables import table_named

    if after is None and (where or mapping or condition is not None):
        raise InputError("--where, --mapping and --condition are of tests that were made; give those by --after")
    chosen = table_named(terms)
    at_speeds = () if speed is None else tuple(speeds("--speed", speed).tolist())
    at_depths = () if depths is None else tuple(numbers("--depths", depths).tolist())
    tank = Tank(run_length, clearance, speeds=at_speeds, depths=at_depths, reach=reach)
    actuators = chosen.actuators
    made = the_condition(read_captive(after, ship, where, actuators, mapping), condition) if after else None
    wanted = tuple(filter(None, targets.split(",")))
    result = plan_tests(
        made.configuration if made else ship, runs, tank=tank, terms=chosen,
        targets=wanted, criterion=criterion, after=made, errors=run_errors_of(run_errors),
    )  # fmt: skip
    if output:
        result.save(output)
    if json:
        print_json(result.to_dict())
    else:
        print_plan(result)
        say_written([output])
    if not result.determined:
        raise SystemExit(1)
