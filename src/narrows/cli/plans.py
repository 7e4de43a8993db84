"""``plan``: the tests to run next."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from narrows.cli.declarations import Argument, Option
from narrows.cli.options import RunErrors, SelectionOptions, TableDelivery, TermsName, verb
from narrows.errors import InputError

if TYPE_CHECKING:
    from narrows.captive.tests import Tests
    from narrows.experiment_design import Tank
    from narrows.terms.term import TermTable


@dataclass(frozen=True)
class RunOptions:
    runs: Annotated[int, Option(help="How many runs there is time for.")] = 12
    run_length: Annotated[float | None, Option(help="Of steady motion in one run [m]; 10 ship lengths.")] = None
    clearance: Annotated[float, Option(help="Least distance from the hull's side to a wall, in beams.")] = 1.5
    speed: Annotated[
        str | None,
        Option(
            help="To run at: 0.6m/s,0.9m/s or from:to:count; those tested before, or three slow ones, unless given."
        ),
    ] = None
    depths: Annotated[
        str | None, Option(help="To run at [m]: a,b,c or from:to:count; for terms that know the depth.")
    ] = None
    reach: Annotated[
        float | None, Option(help="Farthest offset from the centreline [m]; within what was tested unless given.")
    ] = None

    def tank(self) -> "Tank":
        from narrows.cli.options import numbers, speeds
        from narrows.experiment_design import Tank

        at_speeds = () if self.speed is None else tuple(speeds("--speed", self.speed).tolist())
        at_depths = () if self.depths is None else tuple(numbers("--depths", self.depths).tolist())
        return Tank(self.run_length, self.clearance, speeds=at_speeds, depths=at_depths, reach=self.reach)


@dataclass(frozen=True)
class AimOptions:
    run_errors: RunErrors = "0.02,0.02,0.02"
    terms: TermsName = "paper"
    targets: Annotated[str, Option(help="Coefficients that matter, a,b,c; the bank's unless given.")] = ""
    criterion: Annotated[str, Option(help="'c': sum of the variances; 'd': determinant.")] = "c"

    def options(self, terms: "TermTable") -> dict[str, Any]:
        """What ``plan_tests`` is told of it."""
        from narrows.identification.run_errors import run_errors_of

        targets = tuple(filter(None, self.targets.split(",")))
        errors = run_errors_of(self.run_errors)
        return {"terms": terms, "targets": targets, "criterion": self.criterion, "errors": errors}


@verb("narrows plan ship.toml --runs 12 --speed 0.6m/s,0.9m/s -o runs.csv")
def plan(
    ship: Annotated[Path, Argument(help="Ship file: TOML with [ship], [canal], [water].")],
    runs: RunOptions,
    aim: AimOptions,
    selection: SelectionOptions,
    delivery: TableDelivery,
    after: Annotated[Path | None, Option(help="Captive tests that were made already.")] = None,
) -> None:
    """Propose the captive tests that make the bank's coefficients best known."""
    from narrows.experiment_design import plan_tests
    from narrows.report.printed_tables import print_plan
    from narrows.terms.tables import table_named

    terms = table_named(aim.terms)
    made = _made(after, ship, selection, terms)
    tested = made.configuration if made else ship
    result = plan_tests(tested, runs.runs, tank=runs.tank(), after=made, **aim.options(terms))
    delivery.write(result.save)
    delivery.tell(result.to_dict, lambda: print_plan(result))
    raise SystemExit(int(not result.determined))


def _made(after: Path | None, ship: Path, selection: SelectionOptions, terms: "TermTable") -> "Tests | None":
    from narrows.captive import read_captive
    from narrows.identification.conditions import the_condition

    if after is None:
        if selection != SelectionOptions():
            raise InputError("--where, --mapping and --condition are of tests that were made; give those by --after")
        return None
    read = read_captive(after, ship, selection.where, terms.actuators, selection.mapping)
    return the_condition(read, selection.condition)
