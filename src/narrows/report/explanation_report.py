"""A model on a table of tests, in the terminal and as one self-contained page."""

from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

from narrows.files import write_whole
from narrows.identification import Comparison, Explanation
from narrows.quantities.names import FORCES
from narrows.report.fit_figures import comparison_figure
from narrows.report.fit_page import figure, render, section
from narrows.report.fit_table import coefficient_row, heading, print_fit
from narrows.report.terminal import console_of, table_of


def write_explanation(explanation: Explanation, path: str | Path, title: str) -> None:
    rows = explanation.comparison.rows()
    page = render(
        "explanation.html.j2",
        title=title,
        says=[*explanation.summary().splitlines(), *explanation.notes],
        forces=tuple(explanation.scores),
        units={force: quantity.unit for force, quantity in FORCES.items()},
        scores=explanation.scores,
        by_test=explanation.by_test,
        coefficients=[_row(explanation, name) for name in explanation.fit.terms.names],
        compared=explanation.comparison.summary().splitlines(),
        left_out=explanation.comparison.left_out,
        comparison=figure(comparison_figure(rows), "Errors of tables of terms, of the fit and on left-out tests."),
        rows=[row | {"said": bank_said(row)} for row in rows],
        s=section("", explanation.fit, 0) | {"heading": f"A fit to these tests: {heading(explanation.fit, '')}"},
    )
    write_whole(path, page)


def _row(explanation: Explanation, name: str) -> dict[str, Any]:
    own = {"model": f"{explanation.model.coefficients[name]:.4g}", "apart": explanation.distance[name]}
    return coefficient_row(explanation.fit, name) | own


def bank_said(row: dict[str, Any]) -> str:
    return "; ".join(
        f"{name} {coefficient['ci95'][0]:.3g} to {coefficient['ci95'][1]:.3g} ({coefficient['verdict']})"
        if np.isfinite(coefficient["ci95"]).all()
        else f"{name} ({coefficient['verdict']})"
        for name, coefficient in row["bank"].items()
    )


def print_explanation(explanation: Explanation, label: str = "") -> None:
    console = console_of()
    for sentence in (*explanation.summary().splitlines(), *explanation.notes):
        console.print(f"- {sentence}")
    rows = (_row(explanation, name) for name in explanation.fit.terms.names)
    console.print(table_of(COLUMNS, rows, left=("", "unit"), no_wrap=True, title="The model and these tests"))
    print_fit(explanation.fit, label)
    print_comparison(explanation.comparison, console)


COLUMNS = {
    "": "{name}", "model": "{model}", "these tests": "{value}", "95 % interval": "{interval}",
    "apart [std. errors]": "{apart:+.1f}", "unit": "{unit}",
}  # fmt: skip
COMPARED = {
    "terms": "{table}", "force": "{force}", "fit": "{rmse:.3g}", "tests left out": "{rmse_left_out:.3g}",
    "speeds left out": "{rmse_other_speeds:.3g}", "not separable": "{not_separable} of {coefficients}",
}  # fmt: skip


def print_comparison(comparison: Comparison, console: Console | None = None) -> None:
    console = console or console_of()
    title = "Tables of terms by their error (RMSE) on left-out tests"
    console.print(table_of(COMPARED, comparison.rows(), left=("terms", "force"), title=title))
    for sentence in comparison.summary().splitlines():
        console.print(f"- {sentence}")
