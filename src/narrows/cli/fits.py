"""``identify``, ``demo``, ``explain`` and ``plan``: models and their uncertainty from tests; tests to make."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated

import click

import narrows as nw
from narrows.base.errors import InputError
from narrows.base.progress import stage
from narrows.cli import options as cli
from narrows.empirical.fleet import model_named

if TYPE_CHECKING:
    from narrows.captive.read import Tests
    from narrows.model.term import TermTable


SIMULATED_SPEEDS = (0.7, 1.0)  # [m/s]


@dataclass(frozen=True)
class FittingOptions:
    balance: Annotated[str, "Units of equal weight: 'tests' of any length, or 'rows'."] = "tests"
    terms: cli.Terms = "paper"
    accelerations: Annotated[
        str, "'checked': from the motion if the measured ones contradict it; 'motion'; 'measured'."
    ] = "checked"
    errors: cli.RunErrors = "0.02,0.02,0.02"
    pass_over: Annotated[
        cli.Words, "'rudder': fit although it moves without a rudder term; other terms absorb its force."
    ] = ""
    pool: Annotated[str | None, "'depth': separate hull coefficients at each depth, one bank."] = None


@cli.verb("narrows identify kcs.csv --ship kcs.toml -o kcs.model.toml --report report.html", apart=("stream report",))
def identify(
    table: cli.Table,
    ship: cli.ShipFile,
    fitting: FittingOptions,
    selection: cli.SelectionOptions,
    delivery: cli.ModelDelivery,
    stream: Annotated[bool, "Read block by block: for tables larger than memory."] = False,
) -> None:
    """Identify coefficients from captive tests, with their verdicts.

    A table that holds several conditions (water depths) gives one model each.
    """
    read, mapping = nw.stream_captive if stream else nw.read_captive, selection.mapping_of(table)
    try:
        tests = read(table, ship, selection.where, mapping=mapping)
        with stage("fitting"):
            fits = nw.identify_conditions(tests, selection.condition, **vars(fitting))
    except InputError as error:
        raise InputError(f"{error}{'' if mapping else _drafted(table, ship)}") from None
    publish(fits, table.stem, delivery)


def _drafted(table: Path, ship: Path) -> str:
    """Draft the columns of a table that was refused; return what was done and what to type."""
    from narrows.base.files import write_whole
    from narrows.captive.draft import draft_columns
    from narrows.captive.formats import is_known
    from narrows.readers.frames import read_frame
    from narrows.readers.mapping import read_mapping

    path = table.with_name("columns.toml")
    try:
        frame = read_frame(table).frame
        there = read_mapping(path if path.exists() else None)
        if there and not {*there.columns.values()} <= {*frame.columns}:
            path = table.with_suffix(".columns.toml")  # The other one is that of another table
        command = f"narrows identify {table} --ship {ship} --mapping {path}"
        if path.exists():
            return f" ({path} is there: check it, and type {command})"
        draft = draft_columns(frame)
        if not draft.entries or is_known(frame):  # The columns of a known layout are not at fault.
            return ""
        write_whole(path, draft.toml(table.name, command))
    except (InputError, OSError):
        return ""
    return f"; {path} is drafted: check it, and type {command}"


@cli.verb("narrows demo -o out")
def demo(
    out: Annotated[Path, cli.Option("--out", "-o", help="Folder for the report and the models.")] = Path("out"),
    json: cli.AsJson = False,
) -> None:
    """Identify the bundled tests, and write a report.

    The first are simulated tests of the DTC with a known bank; then measured ones of the KCS at three depths.
    """
    cli.folder(out)
    fits = nw.identify_conditions(nw.measured_tests("kcs"))
    delivery = cli.Delivery(out / "kcs.toml", json, report=out / "report.html")
    publish(fits, "simulated and measured tests", delivery, {"simulated tests": _simulated()})


def _simulated() -> "nw.Fit":
    """A fit to simulated tests that separate the bank from the hull: harmonic runs, straight runs to both sides."""
    yaw_and_sway = product(("yaw", "sway"), SIMULATED_SPEEDS, (14.0, 23.0))
    offsets = product((-2.0, -1.0, 1.0, 1.5, 2.0), SIMULATED_SPEEDS)
    harmonic = [
        nw.HarmonicRun(f"{kind} {u} m/s {period} s", kind, 0.5, period, u, 2) for kind, u, period in yaw_and_sway
    ]
    straight = [nw.StraightRun(f"straight {y} m {u} m/s", y, u, 20.0) for y, u in offsets]
    return nw.identify(nw.twin(runs=[*harmonic, *straight], rate=5.0))


@cli.verb("narrows explain out/kcs-C0101A01.toml kcs.csv --condition C0101A01 --report explained.html")
def explain(
    model: cli.ModelFile,
    table: cli.Table,
    selection: cli.SelectionOptions,
    delivery: cli.ReportDelivery,
    ship: Annotated[Path | None, "Ship file of the tests; the model's own ship unless given."] = None,
    compare: Annotated[cli.Words, "Tables of terms to compare, a,b,c; all unless given."] = "",
) -> None:
    """Evaluate a model on any table of tests.

    It gives the errors of the model, the verdicts of a fit to these tests, and the terms that predict them best.

    MODEL is a model file, or the name of a published model.
    """
    from narrows.identification.fitting import the_condition
    from narrows.report.explanation_report import print_explanation, write_explanation

    chosen = model_named(model)
    mapping = selection.mapping_of(table)
    read = nw.read_captive(table, ship or chosen.configuration, selection.where, chosen.terms.actuators, mapping)
    result = nw.explain(chosen, the_condition(read, selection.condition), compare)
    title = f"{model} on {table.name}"
    delivery.write(result.save, report=lambda path: write_explanation(result, path, title))
    delivery.show(result.to_dict, lambda: print_explanation(result, selection.condition or ""))


def publish(
    fits: dict[str, "nw.Fit"],
    title: str,
    delivery: cli.ModelDelivery,
    first: Mapping[str, "nw.Fit"] = MappingProxyType({}),
) -> None:
    """Save, report and print fits; earlier ones are not saved."""
    from narrows.identification.bank_summary import summarise_bank

    every = {**first, **fits}
    answers = {label: summarise_bank(fit) for label, fit in every.items()}
    written = []
    for label, fit in fits.items() if delivery.output else ():
        assert delivery.output
        written.append(cli.output_of(delivery.output, label) if len(fits) > 1 else delivery.output)
        fit.model.save(written[-1])
    if delivery.report:
        with stage("drawing the report"):
            nw.report.write_report(every, delivery.report, title, answers)
    if delivery.json:
        shown = {label: {"answer": answers[label].to_dict(), **fit.to_dict()} for label, fit in every.items()}
        cli.print_json(next(iter(shown.values())) if len(shown) == 1 else {"conditions": shown})
    else:
        from narrows.report.printed_tables import print_fit

        for label, fit in every.items():
            print_fit(fit, label, answer=answers[label], table=len(every) == 1)
        click.echo("Scores, Shapley shares and every coefficient: add --verbose, or read the report (--report).")
        cli.print_written([*written, delivery.report])
    if any(fit.implausible or not fit.solution.kkt.satisfied for fit in fits.values()):
        raise SystemExit(1)


@cli.verb("narrows reproduce -o paper")
def reproduce(
    out: Annotated[Path, cli.Option("--out", "-o", help="Folder for report.html.")] = Path("out"),
    json: cli.AsJson = False,
) -> None:
    """Reproduce every table and figure of the 2025 paper.

    Numbers of this package are listed with those of the paper.
    """
    from narrows.report.explanation_report import write_reproduction
    from narrows.studies.mikkelsen2025 import reproduce as made

    cli.folder(out)
    result = made(lambda doing: click.echo(f"{doing} ...", err=True))
    click.echo("figures ...", err=True)
    write_reproduction(result, out / "report.html")
    cli.Delivery(json=json, report=out / "report.html").show(result.to_dict, lambda: click.echo(result.summary()))


@dataclass(frozen=True)
class RunOptions:
    runs: Annotated[int, "Number of runs."] = 12
    run_length: Annotated[float | None, "Steady motion in one run [m]; 10 ship lengths."] = None
    clearance: Annotated[float, "Least distance from the hull's side to a wall, in beams."] = 1.5
    speed: Annotated[
        cli.Speeds | None, "Speeds: 0.6m/s,0.9m/s or from:to:count; default: those tested before, or three slow ones."
    ] = None
    depths: Annotated[cli.Numbers | None, "Depths [m]: a,b,c or from:to:count; for terms with depth."] = None
    reach: Annotated[float | None, "Largest offset from the centreline [m]; default: the tested range."] = None

    def tank(self) -> "nw.Tank":
        at_speeds, at_depths = (() if own is None else tuple(own.tolist()) for own in (self.speed, self.depths))
        return nw.Tank(self.run_length, self.clearance, speeds=at_speeds, depths=at_depths, reach=self.reach)


@dataclass(frozen=True)
class AimOptions:
    errors: cli.RunErrors = "0.02,0.02,0.02"
    terms: cli.Terms = "paper"
    targets: Annotated[cli.Words, "Target coefficients, a,b,c; default: the bank's."] = ""


@cli.verb(
    "narrows plan ship.toml --runs 12 --speed 0.6m/s,0.9m/s -o runs.csv", needs={"where mapping condition": "after"}
)
def plan(
    ship: Annotated[Path, cli.Argument(help=cli.SHIP_FILE)],
    runs: RunOptions,
    aim: AimOptions,
    selection: cli.SelectionOptions,
    delivery: cli.TableDelivery,
    after: Annotated[Path | None, "Earlier captive tests."] = None,
) -> None:
    """Choose captive tests that identify the bank."""
    from narrows.report.printed_tables import print_plan

    made = _made(after, ship, selection, aim.terms)
    tested = made.configuration if made else ship
    result = nw.plan_tests(tested, runs.runs, tank=runs.tank(), after=made, **vars(aim))
    delivery.write(result.save)
    delivery.show(result.to_dict, lambda: print_plan(result))
    raise SystemExit(int(not result.determined))


def _made(after: Path | None, ship: Path, selection: cli.SelectionOptions, terms: "TermTable") -> "Tests | None":
    from narrows.identification.fitting import the_condition

    if after is None:
        return None
    read = nw.read_captive(after, ship, selection.where, terms.actuators, selection.mapping_of(after))
    return the_condition(read, selection.condition)
