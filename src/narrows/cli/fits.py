"""``identify``, ``demo`` and ``explain``: tests in, models and what is known of them out."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from narrows.cli.app import app
from narrows.cli.options import (
    AsJson,
    Condition,
    Mapping,
    ModelFile,
    ModelOutput,
    Report,
    ShipFile,
    Table,
    TableOutput,
    TermsName,
    Where,
)
from narrows.cli.output import folder, output_of, print_json, say_written
from narrows.errors import InputError

if TYPE_CHECKING:
    from narrows.identification import Fit
    from narrows.identification.bank_answer import Answer


@app.command(epilog="Example: narrows identify kcs.csv --ship kcs.toml -o kcs.model.toml --report report.html")
def identify(
    table: Table,
    ship: ShipFile,
    output: ModelOutput = None,
    report: Report = None,
    split: Annotated[str, typer.Option(help="Left out for checking: each 'test' in turn, or 'random' rows.")] = "test",
    seed: Annotated[int, typer.Option(help="Of the random split.")] = 0,
    weights: Annotated[str, typer.Option(help="'paper': plain sum of squares; 'variance': scaled.")] = "paper",
    balance: Annotated[str, typer.Option(help="What counts alike: 'tests', however long, or 'rows'.")] = "tests",
    terms: TermsName = "paper",
    accelerations: Annotated[
        str, typer.Option(help="'checked': of the motion where the measured ones stray; 'motion'; 'measured'.")
    ] = "checked",
    where: Where = None,
    mapping: Mapping = None,
    condition: Condition = None,
    run_errors: Annotated[
        str, typer.Option(help="What runs differ by: gain, zero and form, as shares of the force.")
    ] = "0.02,0.02,0.02",
    pass_over: Annotated[
        str, typer.Option(help="'rudder': fit although it moves and no term has it; its force goes to other terms.")
    ] = "",
    pool: Annotated[str | None, typer.Option(help="'depth': hulls of their own at each depth, one bank.")] = None,
    stream: Annotated[bool, typer.Option(help="Read block by block: for tables larger than memory.")] = False,
    json: AsJson = False,
) -> None:
    """Fit the coefficients to captive tests and say which of them can be trusted.

    A table that holds several conditions (water depths) gives one model each.
    """
    from narrows.captive import read_captive, stream_captive
    from narrows.identification.conditions import identify_conditions
    from narrows.identification.uncertainty.run_errors import run_errors_of
    from narrows.progress import stage
    from narrows.terms.tables import table_named

    chosen = table_named(terms)
    if stream and report:
        raise InputError("--report draws the rows, which --stream does not keep; leave one of them out")
    tests = (stream_captive if stream else read_captive)(table, ship, where, mapping=mapping)
    options: dict[str, Any] = {
        "terms": chosen,
        "weights": weights,
        "balance": balance,
        "split": split,
        "seed": seed,
        "accelerations": accelerations,
    }
    passed = tuple(filter(None, pass_over.split(",")))
    options |= {"errors": run_errors_of(run_errors), "pass_over": passed, "pool": pool}
    with stage("fitting"):
        fits = identify_conditions(tests, condition, **options)
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
    mapping: Mapping = None,
    condition: Condition = None,
    output: TableOutput = None,
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
    read = read_captive(table, ship or chosen.configuration, where, chosen.terms.actuators, mapping)
    tests = the_condition(read, condition)
    result = explained(chosen, tests, tuple(filter(None, compare.split(","))))
    if output:
        result.save(output)
    if report:
        write_explanation(result, report, f"{model} on {table.name}")
    if json:
        print_json(result.to_dict())
        return
    print_explanation(result, condition or "")
    say_written((output, report))


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
    from narrows.identification.bank_answer import answer_of
    from narrows.model.model_file import save_model

    answers = {label: answer_of(fit) for label, fit in fits.items()}
    written = []
    for label, fit in fits.items():
        if output:
            path = output_of(output, label) if len(fits) > 1 else output
            save_model(fit.model, path)
            written.append(path)
    if report:
        from narrows.progress import stage
        from narrows.report.fit_page import write_report

        with stage("drawing the report"):
            write_report(fits, report, title, answers)
        written.append(report)
    _show(fits, answers, json)
    if not json:
        say_written(written)
    if any(fit.implausible or not fit.solution.kkt.satisfied for fit in fits.values()):
        raise SystemExit(1)


def _show(fits: dict[str, "Fit"], answers: dict[str, "Answer"], json: bool) -> None:
    if json:
        shown = {label: {"answer": answers[label].to_dict(), **fit.to_dict()} for label, fit in fits.items()}
        print_json(next(iter(shown.values())) if len(shown) == 1 else {"conditions": shown})
        return
    from narrows.report.fit_table import print_fit

    for label, fit in fits.items():
        print_fit(fit, label, answer=answers[label])
