"""The command line: one thin command a verb. Exit code 0; 1 where it ran and says no; 2 for bad input."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NoReturn

import typer

from narrows.errors import InputError

if TYPE_CHECKING:
    from narrows.identification import Fit

app = typer.Typer(
    name="narrows",
    help="From captive model tests to a closed-form bank-effect model that says how far it can be trusted.",
    epilog="--debug, anywhere, shows the traceback of an error.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
)

Table = Annotated[Path, typer.Argument(help="Captive tests: CSV, Parquet, .mat or .dat.", show_default=False)]
ShipFile = Annotated[Path, typer.Option("--ship", help="Ship file: TOML with [ship], [canal], [water].")]
ModelFile = Annotated[str, typer.Argument(help="Model file, or the name of a published model.", show_default=False)]
Duration = Annotated[float, typer.Option(help="Longest time of a voyage [s].")]
TimeStep = Annotated[float, typer.Option(help="Time step [s].")]
Surge = Annotated[str, typer.Option(help="'held': the speed stays; 'free': it is integrated.")]
SurgeInertia = Annotated[float | None, typer.Option(help="Mass in surge with its added mass [kg], for 'free'.")]
Coriolis = Annotated[bool, typer.Option("--coriolis", help="Add the rigid body's Coriolis force.")]
ContactKind = Annotated[str, typer.Option(help="What meets the bank: hull 'corners' or 'midship' clearance.")]
TermsName = Annotated[str, typer.Option(help="Table of terms: 'paper', 'speed', 'crossflow', 'paper+keel_gap', ...")]
Where = Annotated[str | None, typer.Option(help="Rows to take, as in 'u > 0.3', on the table's headers.")]
Condition = Annotated[str | None, typer.Option(help="Take this condition of the table alone.")]
Report = Annotated[Path | None, typer.Option(help="Self-contained HTML report to write.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON instead of tables.")]


@app.callback()
def verbs() -> None:
    """Keep the verb in the command line even where there is one verb alone."""


@app.command(epilog="Example: narrows identify kcs.csv --ship kcs.toml -o kcs.model.toml --report report.html")
def identify(
    table: Table,
    ship: ShipFile,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Model file to write.")] = None,
    report: Report = None,
    split: Annotated[str, typer.Option(help="Left out for checking: each 'test' in turn, or 'random' rows.")] = "test",
    seed: Annotated[int, typer.Option(help="Of the random split.")] = 0,
    weights: Annotated[str, typer.Option(help="'paper': plain sum of squares; 'variance': scaled.")] = "paper",
    terms: TermsName = "paper",
    where: Where = None,
    condition: Condition = None,
    stream: Annotated[bool, typer.Option(help="Read block by block: for tables larger than memory.")] = False,
    json: AsJson = False,
) -> None:
    """Fit the coefficients to captive tests and say which of them can be trusted.

    A table that holds several conditions (water depths) gives one model each.
    """
    from narrows.captive import read_captive, stream_captive
    from narrows.identification.conditions import identify_each
    from narrows.tables import table_named

    chosen = table_named(terms)
    if stream and report:
        raise InputError("--report draws the rows, which --stream does not keep; leave one of them out")
    tests = (stream_captive if stream else read_captive)(table, ship, chosen, where)
    fits = identify_each(tests, condition, terms=chosen, weights=weights, split=split, seed=seed)
    publish(fits, table.stem, output, report, json)


@app.command(
    epilog="Example: narrows explain out/kcs-C0101A01.toml kcs.csv --condition C0101A01 --report explained.html"
)
def explain(
    model: ModelFile,
    table: Table,
    ship: Annotated[
        Path | None, typer.Option("--ship", help="Ship file of the tests; the model's own ship unless given.")
    ] = None,
    compare: Annotated[str, typer.Option(help="Tables of terms to compare, a,b,c; all unless given.")] = "",
    where: Where = None,
    condition: Condition = None,
    report: Report = None,
    json: AsJson = False,
) -> None:
    """Put a model on any table of tests: its errors, what those tests can say of it, and which terms they prefer.

    MODEL is a model file, or the name of a published model.
    """
    from narrows.captive import read_captive
    from narrows.identification import explain as explained
    from narrows.identification.conditions import the_condition
    from narrows.model_file import model_named
    from narrows.report.explanation import print_explanation, write_explanation

    chosen = model_named(model)
    tests = the_condition(read_captive(table, ship or chosen.setting, chosen.terms, where), condition)
    found = explained(chosen, tests, tuple(filter(None, compare.split(","))))
    if report:
        write_explanation(found, report, f"{model} on {table.name}")
    if json:
        _print_json(found.summary())
        return
    print_explanation(found, condition or "")
    if report:
        typer.echo(f"wrote {report}")


@app.command(epilog="Example: narrows design ship.toml --runs 12 --speeds 0.6,0.9 -o runs.csv")
def design(
    ship: Annotated[Path, typer.Argument(help="Ship file: TOML with [ship], [canal], [water].", show_default=False)],
    runs: Annotated[int, typer.Option(help="How many runs there is time for.")] = 12,
    run_length: Annotated[float, typer.Option(help="Of steady motion in one run [m].")] = 40.0,
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
    from narrows.particulars import read_ship
    from narrows.planning import Tank, plan_tests
    from narrows.report.plans import print_plan, write_plan
    from narrows.tables import table_named

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
        _print_json(plan.summary())
        return
    print_plan(plan)
    if output:
        typer.echo(f"wrote {output}")


def numbers(text: str, option: str) -> tuple[float, ...]:
    """Read numbers between commas (ours).

    Parameters
    ----------
    text : str
        As given.
    option : str
        What they were given for.

    Raises
    ------
    InputError
        Where one is no number.
    """
    try:
        return tuple(float(word) for word in text.split(",") if word)
    except ValueError:
        raise InputError(f"{option} {text!r} is not numbers between commas; write 0.6,0.9") from None


@app.command(epilog="Example: narrows demo --out out")
def demo(
    out: Annotated[Path, typer.Option(help="Folder for the report and the models.")] = Path("out"),
    json: AsJson = False,
) -> None:
    """Run the main job on the bundled tests: the KCS in a 7 m tank, at three depths."""
    from narrows.identification.conditions import identify_each
    from narrows.measured import measured_tests

    _folder(out)
    fits = identify_each(measured_tests("kcs"))
    publish(fits, "kcs", out / "kcs.toml", out / "report.html", json)


@app.command(epilog="Example: narrows simulate mikkelsen2025_dtc --y 0.5 --u 1.0 -o voyage.nc --plot voyage.png")
def simulate(
    model: ModelFile,
    y: Annotated[float, typer.Option(help="Start to starboard of the centreline [m].")] = 0.0,
    u: Annotated[float, typer.Option(help="Surge velocity [m/s].")] = 1.0,
    psi_deg: Annotated[float, typer.Option(help="Heading at the start [deg].")] = 0.0,
    v: Annotated[float, typer.Option(help="Sway velocity at the start [m/s].")] = 0.0,
    r_deg: Annotated[float, typer.Option(help="Yaw rate at the start [deg/s].")] = 0.0,
    surge_force: Annotated[float, typer.Option("--X", help="Surge force from elsewhere [N].")] = 0.0,
    sway_force: Annotated[float, typer.Option("--Y", help="Sway force from elsewhere [N].")] = 0.0,
    yaw_moment: Annotated[float, typer.Option("--N", help="Yaw moment from elsewhere [N m].")] = 0.0,
    duration: Duration = 60.0,
    dt: TimeStep = 0.02,
    surge: Surge = "held",
    surge_inertia: SurgeInertia = None,
    coriolis: Coriolis = False,
    contact: ContactKind = "corners",
    method: Annotated[str, typer.Option(help="'rk4', or 'dop853' as the check on it.")] = "rk4",
    output: Annotated[Path | None, typer.Option("--output", "-o", help="NetCDF file of the voyage to write.")] = None,
    plot: Annotated[Path | None, typer.Option(help="Picture to write: PNG, SVG or PDF.")] = None,
    json: AsJson = False,
) -> None:
    """Simulate one voyage: where, when and on which side the ship grounds.

    MODEL is a model file, or the name of a published model.
    """
    from math import radians

    from narrows.model_file import model_named
    from narrows.simulation.voyage import simulate as run

    voyage = run(
        model_named(model), y, u, duration, dt, psi=radians(psi_deg), v=v, r=radians(r_deg),
        X=surge_force, Y=sway_force, N=yaw_moment, surge=surge, surge_inertia=surge_inertia, coriolis=coriolis,
        contact=contact, method=method,
    )  # fmt: skip
    if output:
        voyage.save(output)
    if plot:
        from narrows.report.voyages import save_figure, voyage_figure

        save_figure(voyage_figure(voyage, model_named(model).setting), plot)
    if json:
        _print_json(voyage.outcome.as_json())
    else:
        typer.echo(voyage.outcome.sentence)
    raise SystemExit(int(voyage.outcome.kind == "diverged"))


@app.command("map", epilog="Example: narrows map mikkelsen2025_dtc --y -2.5:2.5:101 --u 0.6:1.2:61 --plot map.png")
def map_(
    model: ModelFile,
    y: Annotated[str, typer.Option(help="Start to starboard [m]: a number, a,b,c or from:to:count.")] = "-2.5:2.5:101",
    u: Annotated[str, typer.Option(help="Surge velocity [m/s], likewise.")] = "1.0",
    psi_deg: Annotated[str, typer.Option(help="Heading at the start [deg], likewise.")] = "0",
    width: Annotated[str | None, typer.Option(help="Canal width [m], likewise; the model's own unless given.")] = None,
    draws: Annotated[int, typer.Option(help="Of the coefficients from the fit's covariance.")] = 0,
    within: Annotated[
        float | None, typer.Option(help="With --draws: map the probability of grounding so near [m].")
    ] = None,
    seed: Annotated[int, typer.Option(help="Of the draws.")] = 0,
    duration: Duration = 60.0,
    dt: TimeStep = 0.02,
    contact: ContactKind = "corners",
    output: Annotated[Path | None, typer.Option("--output", "-o", help="NetCDF file of the map to write.")] = None,
    plot: Annotated[Path | None, typer.Option(help="Picture to write: PNG, SVG or PDF.")] = None,
    json: AsJson = False,
) -> None:
    """Map where the ship grounds over one or two things that vary, or how likely she does.

    MODEL is a model file, or the name of a published model.
    """
    from narrows.model_file import model_named
    from narrows.simulation.maps import map_summary, mapped
    from narrows.simulation.netcdf import save_netcdf

    if within is not None and not draws:
        raise InputError("--within maps a probability, which needs draws of the coefficients: add --draws 200")
    chosen, ranges = model_named(model), {"--y": y, "--u": u, "--psi-deg": psi_deg, "--width": width}
    shown = sys.stderr.isatty() and not json
    options = {"duration": duration, "dt": dt, "draws": draws, "seed": seed, "contact": contact, "progress": shown}
    voyages = mapped(chosen, ranges, **options)
    if output:
        save_netcdf(voyages, output)
    if plot:
        from narrows.report.voyages import map_figure, save_figure

        save_figure(map_figure(voyages, chosen.setting, within), plot)
    summary = map_summary(voyages)
    _print_json(summary) if json else typer.echo(summary["says"])


@app.command(epilog="Example: narrows reproduce --out paper")
def reproduce(
    out: Annotated[Path, typer.Option(help="Folder for report.html.")] = Path("out"),
    json: AsJson = False,
) -> None:
    """Make every table and figure of the paper again, ours beside its own numbers."""
    from narrows.report.paper import write_reproduction

    _folder(out)
    numbers = write_reproduction(out / "report.html", lambda doing: typer.echo(f"{doing} ...", err=True))
    if json:
        _print_json(numbers)
        return
    for reading in numbers["readings"]:
        where = "nowhere" if reading["switch"] is None else f"from y(0) = {reading['switch']:.2f} m"
        typer.echo(f"grounds on the near bank {where}: {reading['name']}")
    typer.echo(f"wrote {out / 'report.html'}")


def _folder(path: Path) -> None:
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{path}: cannot be made a folder ({error.strerror}); choose another") from None


def publish(fits: dict[str, "Fit"], title: str, output: Path | None, report: Path | None, json: bool) -> None:
    """Print fits, and write what was asked for (ours).

    Parameters
    ----------
    fits : dict of str to Fit
        By condition; the label is empty where there is one.
    title : str
        Of the report.
    output : Path, optional
        Model file; with several conditions each adds its label to the name.
    report : Path, optional
        HTML file.
    json : bool
        Print JSON.
    """
    from narrows.model_file import save_model

    written = []
    for label, fit in fits.items():
        if output:
            path = output.with_stem(f"{output.stem}-{label}") if len(fits) > 1 else output
            save_model(fit.model, path)
            written.append(path)
    if report:
        from narrows.report.page import write_report

        write_report(fits, report, title)
        written.append(report)
    _show(fits, json)
    if not json:
        typer.echo("\n".join(f"wrote {path}" for path in written))
    if not all(fit.kkt.satisfied for fit in fits.values()):
        raise SystemExit(1)


def _show(fits: dict[str, "Fit"], json: bool) -> None:
    if json:
        shown = {label: fit.summary() for label, fit in fits.items()}
        _print_json(next(iter(shown.values())) if len(shown) == 1 else {"conditions": shown})
        return
    from narrows.report.terminal import print_fit

    for label, fit in fits.items():
        print_fit(fit, label)


def _print_json(value: object) -> None:
    from json import dumps

    typer.echo(dumps(value, indent=2, allow_nan=False))


def main() -> NoReturn:
    """Run the command line: bad input is one line on stderr and exit code 2."""
    debug = "--debug" in sys.argv
    arguments = [word for word in sys.argv[1:] if word != "--debug"]
    try:
        code = app(arguments, standalone_mode=False)
    except InputError as error:
        if debug:
            raise
        _leave(str(error), 2)
    except KeyboardInterrupt:
        _leave("interrupted", 130)
    except Exception as error:
        if debug or not hasattr(error, "format_message"):
            raise
        _leave(f"{error.format_message()} (see narrows --help)", 2)
    raise SystemExit(code if isinstance(code, int) else 0)


def _leave(sentence: str, code: int) -> NoReturn:
    typer.echo(f"narrows: {sentence}", err=True)
    raise SystemExit(code)
