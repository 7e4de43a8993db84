"""``identify``, ``demo`` and ``explain``: tests in, models and what is known of them out."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from narrows.cli.app import app
from narrows.cli.options import AsJson, Condition, ModelFile, Report, ShipFile, Table, TermsName, Where
from narrows.cli.output import folder, output_of, print_json
from narrows.errors import InputError

if TYPE_CHECKING:
    from narrows.identification import Fit


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
    from narrows.identification.conditions import identify_conditions
    from narrows.terms.tables import table_named

    chosen = table_named(terms)
    if stream and report:
        raise InputError("--report draws the rows, which --stream does not keep; leave one of them out")
    tests = (stream_captive if stream else read_captive)(table, ship, chosen, where)
    fits = identify_conditions(tests, condition, terms=chosen, weights=weights, split=split, seed=seed)
    publish(fits, table.stem, output, report, json)


@app.command(epilog="Example: narrows demo -o out")
def demo(
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the report and the models.")] = Path("out"),
    json: AsJson = False,
) -> None:
    """Run the main job on the bundled tests: the KCS in a 7 m tank, at three depths."""
    from narrows.captive.measured import measured_tests
    from narrows.identification.conditions import identify_conditions

    folder(out)
    fits = identify_conditions(measured_tests("kcs"))
    publish(fits, "kcs", out / "kcs.toml", out / "report.html", json)


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
    from narrows.model.model_file import model_named
    from narrows.report.explanation_report import print_explanation, write_explanation

    chosen = model_named(model)
    tests = the_condition(read_captive(table, ship or chosen.configuration, chosen.terms, where), condition)
    found = explained(chosen, tests, tuple(filter(None, compare.split(","))))
    if report:
        write_explanation(found, report, f"{model} on {table.name}")
    if json:
        print_json(found.to_dict())
        return
    print_explanation(found, condition or "")
    if report:
        typer.echo(f"wrote {report}")


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
    from narrows.model.model_file import save_model

    written = []
    for label, fit in fits.items():
        if output:
            path = output_of(output, label) if len(fits) > 1 else output
            save_model(fit.model, path)
            written.append(path)
    if report:
        from narrows.report.fit_page import write_report

        write_report(fits, report, title)
        written.append(report)
    _show(fits, json)
    if not json:
        typer.echo("\n".join(f"wrote {path}" for path in written))
    if not all(fit.solution.kkt.satisfied for fit in fits.values()):
        raise SystemExit(1)


def _show(fits: dict[str, "Fit"], json: bool) -> None:
    if json:
        shown = {label: fit.to_dict() for label, fit in fits.items()}
        print_json(next(iter(shown.values())) if len(shown) == 1 else {"conditions": shown})
        return
    from narrows.report.fit_table import print_fit

    for label, fit in fits.items():
        print_fit(fit, label)
