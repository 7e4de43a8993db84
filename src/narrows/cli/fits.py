"""``identify``, ``demo``, ``explain``, ``plan``: models from tests; ``estimate``, ``scale``, ``export``, ``ships``."""

from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Annotated, Any

import click

import narrows as nw
import narrows.report.printed_tables as tables
from narrows.base.errors import InputError
from narrows.base.files import to_json, write_whole
from narrows.base.progress import stage
from narrows.cli import options as cli
from narrows.cli.voyages import OF_WATERWAY, PhysicsOptions, WaterOptions
from narrows.empirical.fleet import model_named, table_of_ships
from narrows.export import EXPORTERS

SIMULATED_SPEEDS = (0.7, 1.0)  # [m/s]


@dataclass(frozen=True)
class FittingOptions:
    balance: Annotated[str, "Units of equal weight: 'tests' of any length, or 'rows'."] = "tests"
    terms: cli.Terms = "paper"
    accelerations: Annotated[str, "'motion', 'measured', or 'checked': measured unless the motion differs."] = "checked"
    errors: cli.RunErrors = "0.02,0.02,0.02"
    pass_over: Annotated[cli.Words, "'rudder': fit without terms of a moving rudder; others absorb its force."] = ""
    pool: Annotated[str | None, "'depth': separate hull coefficients at each depth, one bank."] = None


@cli.verb("narrows identify kcs.csv --ship kcs.toml -o kcs.model.toml --report report.html", apart=("stream report",))
def identify(
    table: cli.Table,
    fitting: FittingOptions,
    selection: cli.SelectionOptions,
    delivery: cli.ModelDelivery,
    ship: cli.ShipFile = None,
    stream: Annotated[bool, "Read block by block: for tables larger than memory."] = False,
) -> None:
    """Identify coefficients from captive tests, with their verdicts.

    A table that holds several conditions (water depths) gives one model each.
    """
    table, source = _files(table, ship)
    read, mapping = nw.stream_captive if stream else nw.read_captive, selection.mapping_of(table)
    try:
        tests = read(table, source, selection.where, mapping=mapping)
        with stage("fitting"):
            fits = nw.identify_conditions(tests, selection.condition, **vars(fitting))
    except InputError as error:
        raise InputError(f"{error}{'' if mapping else _drafted(table, ship)}") from None
    publish(fits, table.stem, delivery)


def _files(table: Path, ship: Any) -> tuple[Path, Any]:
    """Return the files of a table and its ship, or of the package's tests of that name."""
    from narrows.captive.measured import TABLES, measured_files

    return measured_files(str(table)) if str(table) in TABLES and not table.exists() else (table, ship)


def _drafted(table: Path, ship: Path | None) -> str:
    """Draft the columns of a table that was refused; return what was done and what to type."""
    from narrows.captive.columns import draft_columns
    from narrows.captive.layouts import layout_of
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
        draft = draft_columns(frame, table.name, command)
        if not draft or layout_of(frame):  # The columns of a known layout are not at fault.
            return ""
        write_whole(path, draft)
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
    motions = product(("yaw", "sway"), SIMULATED_SPEEDS, (14.0, 23.0))
    offsets = product((-2.0, -1.0, 1.0, 1.5, 2.0), SIMULATED_SPEEDS)
    harmonic = [nw.HarmonicRun(f"{kind} {u} m/s {period} s", kind, 0.5, period, u, 2) for kind, u, period in motions]
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
    """
    from narrows.report.fit_page import write_explanation

    chosen = model_named(model)
    result = nw.explain(chosen, _tests(table, ship or chosen.configuration, selection, chosen.terms), compare)
    delivery.give(
        result, lambda result: tables.print_explanation(result, selection.condition or ""),
        report=lambda path: write_explanation(result, path, f"{model} on {table.name}"),
    )  # fmt: skip


@cli.verb("narrows compare kcs.csv --ship kcs.toml --condition C0101A01 --terms paper,speed,crossflow")
def compare(
    table: cli.Table,
    selection: cli.SelectionOptions,
    delivery: cli.TableDelivery,
    ship: cli.ShipFile = None,
    terms: Annotated[cli.Words, "Tables of terms, a,b,c; all unless given."] = "",
) -> None:
    """Rank tables of terms by their errors on left-out tests."""
    delivery.give(nw.compare(_tests(table, ship, selection, nw.PAPER), terms), tables.print_comparison)


def _tests(table: Path, ship: Any, selection: cli.SelectionOptions, terms: "nw.TermTable") -> Any:
    from narrows.identification.fitting import the_condition

    table, ship = _files(table, ship)
    read = nw.read_captive(table, ship, selection.where, terms.actuators, selection.mapping_of(table))
    return the_condition(read, selection.condition)


def publish(
    fits: dict[str, "nw.Fit"], title: str, delivery: cli.ModelDelivery, first: dict[str, "nw.Fit"] | None = None
) -> None:
    """Save, report and print fits; earlier ones are not saved."""
    from narrows.identification.bank_summary import summarise_bank

    every = {**(first or {}), **fits}
    answers = {label: summarise_bank(fit) for label, fit in every.items()}
    written = [cli.output_of(delivery.output, label, len(fits)) for label in fits] if delivery.output else []
    for path, fit in zip(written, fits.values(), strict=False):
        fit.model.save(path)
    if delivery.report:
        with stage("drawing the report"):
            nw.report.write_report(every, delivery.report, title, answers)
    if delivery.json:
        shown = {label: {"answer": answers[label].to_dict(), **fit.to_dict()} for label, fit in every.items()}
        click.echo(to_json(next(iter(shown.values())) if len(shown) == 1 else {"conditions": shown}))
    else:
        for label, fit in every.items():
            tables.print_fit(fit, label, answer=answers[label], table=len(every) == 1)
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
    from narrows.report.fit_page import write_reproduction
    from narrows.studies.mikkelsen2025 import reproduce as made

    cli.folder(out)
    result = made(lambda doing: click.echo(f"{doing} ...", err=True))
    click.echo("figures ...", err=True)
    write_reproduction(result, out / "report.html")
    cli.Delivery(json=json, report=out / "report.html").show(result.to_dict, lambda: click.echo(result.summary()))


@cli.verb(
    "narrows plan ship.toml --runs 12 --speed 0.6m/s,0.9m/s -o runs.csv", needs={"where mapping condition": "after"}
)
def plan(
    ship: Annotated[Path, cli.Argument(help=f"{cli.SHIP_FILE} Or the name of a published model.")],
    selection: cli.SelectionOptions,
    delivery: cli.TableDelivery,
    runs: Annotated[int, "Number of runs."] = 12,
    run_length: Annotated[float | None, "Steady motion in one run [m]; 10 ship lengths."] = None,
    clearance: Annotated[float, "Least distance from the hull's side to a wall, in beams."] = 1.5,
    speed: Annotated[cli.Speeds | None, "Speeds: 0.6m/s,0.9m/s or from:to:count; default: tested or slow ones."] = None,
    depths: Annotated[cli.Numbers | None, "Depths [m]: a,b,c or from:to:count; for terms with depth."] = None,
    reach: Annotated[float | None, "Largest offset from the centreline [m]; default: the tested range."] = None,
    after: Annotated[Path | None, "Earlier captive tests."] = None,
    errors: cli.RunErrors = "0.02,0.02,0.02",
    terms: cli.Terms = "paper",
    targets: Annotated[cli.Words, "Target coefficients, a,b,c; default: the bank's."] = "",
) -> None:
    """Choose captive tests that identify the bank."""
    source: Any = nw.published(str(ship)) if str(ship) in nw.published() else ship
    made = _tests(after, source, selection, terms) if after else None
    at_speeds, at_depths = (() if own is None else tuple(own.tolist()) for own in (speed, depths))
    aim: dict[str, Any] = {"errors": errors, "terms": terms, "targets": targets}
    aim["tank"] = nw.Tank(run_length, clearance, speeds=at_speeds, depths=at_depths, reach=reach)
    result = nw.plan_tests(made.configuration if made else source, runs, after=made, **aim)
    delivery.give(result, tables.print_plan)
    raise SystemExit(int(not result.determined))


*_FIRST, _LAST = map(repr, EXPORTERS)
WHAT = f"What to write: {', '.join(_FIRST)} or {_LAST}."
*_FIRST, _LAST = dict.fromkeys(suffix for exporter in EXPORTERS.values() for suffix in exporter.suffixes)
WHERE = f"File to write: {', '.join(_FIRST)} or {_LAST}."


@cli.verb("narrows scale mikkelsen2025_dtc --length 355 --density 1025 --depth 24 -o full.toml")
def scale(
    model: cli.ModelFile,
    length: Annotated[float, "Length between perpendiculars of the new ship [m]."],
    delivery: cli.PlainModelDelivery,
    density: Annotated[float | None, "Density of the new water [kg/m3]; default: unchanged."] = None,
    width: Annotated[float | None, "Width of the new canal [m]; default: that of the tests, scaled."] = None,
    depth: Annotated[float | None, "Depth of the new canal [m]; default: that of the tests, scaled."] = None,
) -> None:
    """Scale a model to another length by Froude's law.

    It reports the effects that do not scale.
    """
    scaled = nw.scale_model(model_named(model), length, density, width, depth)
    delivery.give(scaled, tables.print_scaled, save=scaled.model.save)


def _known_kind(context: Any, parameter: Any, kind: str) -> str:
    """Return a kind of file; raise for another one, before options are missed."""
    if kind not in EXPORTERS:
        kinds = ", ".join(f"{name} ({' '.join(own.suffixes)})" for name, own in EXPORTERS.items())
        raise InputError(f"there is no kind {kind!r}; choose {kinds}: the suffix of -o chooses the language")
    return kind


@cli.verb("narrows export c mikkelsen2025_dtc -o dtc.h", needs=OF_WATERWAY)
def export(
    kind: Annotated[str, cli.Argument(help=WHAT, callback=_known_kind)],
    model: cli.ModelFile,
    output: Annotated[Path, cli.Option("--output", "-o", help=WHERE)],
    physics: PhysicsOptions,
    water: WaterOptions,
    fmi: Annotated[int, "FMI version of an FMU: 2 or 3."] = 2,
    hold: Annotated[float | None, "Offset [m] held by a helm in the file."] = None,
    json: cli.AsJson = False,
) -> None:
    """Export a model: C, C++, JavaScript, MATLAB, FMU and more.

    The file contains the equations of the simulation.
    """
    from narrows.simulation.initial_state import voyage_defaults

    exporter = EXPORTERS[kind]
    ship, way = model_named(model), water.read()
    helm = None if hold is None else nw.control.regulator(ship, hold, voyage_defaults(ship).speed, waterway=way)
    options: dict[str, Any] = {"waterway": way, "fmi": fmi, **vars(physics), "controller": helm}
    known = exporter.options
    for option, name in (("waterway", "waterway"), ("hold", "controller")):
        if options[name] is not None and name not in known:
            raise InputError(f"a file of kind {kind} has no {name} of its own to set; leave --{option} out")
    written = nw.export.write(ship, output, kind, **{name: value for name, value in options.items() if name in known})
    notes, platforms = list(exporter.notes(written)), written if kind == "fmu" else ()
    shown = {"summary": f"wrote {output}", "kind": kind, "output": str(output), "platforms": platforms, "notes": notes}
    cli.Delivery(output, json).show(lambda: shown, lambda: click.echo("\n".join(notes), nl=bool(notes)))


@cli.verb("narrows estimate --length 366 --beam 51 --draft 15 --block 0.65 --width 300 --depth 18 -o ship.toml")
def estimate(
    delivery: cli.PlainModelDelivery,
    length: Annotated[float, "Length between perpendiculars [m]."],
    width: Annotated[float, "Width of the canal, from bank to bank [m]."],
    depth: Annotated[float | None, "Depth of the canal [m]; default: deep water."] = None,
    beam: Annotated[float | None, "Beam of the ship [m]; usual for its --type unless given."] = None,
    draft: Annotated[float | None, "Draft of the ship [m]; usual for its --type unless given."] = None,
    block: Annotated[float | None, "Block coefficient; usual for its --type unless given."] = None,
    density: Annotated[float, "Density of the water [kg/m3]."] = 1025.0,
    name: Annotated[str, "Name of the ship."] = "ship",
    kind: Annotated[
        str | None, cli.Option("--type", help="container, tanker, bulk, general, inland or convoy.")
    ] = None,
    speed: Annotated[cli.Speed | None, "Service speed: 12m/s, 16kn; default: usual for the type."] = None,
) -> None:
    """Estimate a model from the main dimensions of a ship.

    Its uncertainty is the error of the formulas on known ships.
    """
    ship = {"length": length, "beam": beam, "draft": draft, "block_coefficient": block, "name": name}
    model = nw.estimate_model(ship, nw.Canal(width, depth), nw.Water(density), kind=kind, speed=speed)
    coefficients = model.to_dataframe()[["value", "std", "unit"]].to_dict("index")
    shown = {"coefficients": coefficients, "summary": model.summary(), "notes": list(model.notes)}
    delivery.give(model, tables.print_estimate, values=lambda: shown)


@cli.verb("narrows ships")
def ships(
    model: Annotated[str | None, cli.Argument(help="Model to show: a file, or the name of a published model.")] = None,
    json: cli.AsJson = False,
) -> None:
    """List the available ships, or show one model.

    Each name of the list replaces a model file.
    """
    one = model_named(model) if model is not None else None
    table = nw.ready_ships() if model is None else table_of_ships([model])
    summary = one.summary() if one else f"{len(table)} ships; each name replaces a model file"
    notes = list(one.notes) if one else []
    shown = {"ships": table.reset_index().to_dict("records"), "summary": summary, "notes": notes}
    cli.Delivery(json=json).show(lambda: shown, lambda: tables.print_model(one) if one else tables.print_ships(table))
