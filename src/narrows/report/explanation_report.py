"""Pages of a model on a table of tests, and of the reproduction of the paper; the former in the terminal too."""

from pathlib import Path
from typing import Any

import numpy as np

from narrows.identification import Explanation, Fit
from narrows.identification.shapley import KINDS
from narrows.quantities.names import FORCES
from narrows.report import fit_figures as draw
from narrows.report.fit_figures import comparison_figure
from narrows.report.fit_page import figure, section, write_page
from narrows.report.printed_tables import coefficient_row, console_of, heading, print_fit, table_of
from narrows.report.voyage_figures import distances_figure, paths_figure
from narrows.simulation.ensemble import grounding_distance
from narrows.studies.mikkelsen2025 import PRINTED_SHARES, PRINTED_SWITCH, Reproduction


def write_explanation(explanation: Explanation, path: str | Path, title: str) -> None:
    rows = explanation.comparison.rows()
    write_page(
        path,
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
        rows=[row | {"said": "; ".join(map(_said, row["bank"], row["bank"].values()))} for row in rows],
        s=section("", explanation.fit, 0) | {"heading": f"A fit to these tests: {heading(explanation.fit, '')}"},
    )


def _row(explanation: Explanation, name: str) -> dict[str, Any]:
    own = {"model": f"{explanation.model.coefficients[name]:.4g}", "apart": explanation.z_scores[name]}
    return coefficient_row(explanation.fit, name) | own


def _said(name: str, coefficient: dict[str, Any]) -> str:
    low, high = coefficient["ci95"]
    known = f" {low:.3g} to {high:.3g}" if np.isfinite([low, high]).all() else ""
    return f"{name}{known} ({coefficient['verdict']})"


def print_explanation(explanation: Explanation, label: str = "") -> None:
    console = console_of()
    for sentence in (*explanation.summary().splitlines(), *explanation.notes):
        console.print(f"- {sentence}")
    rows = (_row(explanation, name) for name in explanation.fit.terms.names)
    console.print(table_of(COLUMNS, rows, left=("", "unit"), no_wrap=True, title="The model and these tests"))
    print_fit(explanation.fit, label)
    title = "Tables of terms by their error (RMSE) on left-out tests"
    console.print(table_of(COMPARED, explanation.comparison.rows(), left=("terms", "force"), title=title))
    for sentence in explanation.comparison.summary().splitlines():
        console.print(f"- {sentence}")


COLUMNS = {
    "": "{name}", "model": "{model}", "these tests": "{value}", "95 % interval": "{interval}",
    "apart [std. errors]": "{apart:+.1f}", "unit": "{unit}",
}  # fmt: skip
COMPARED = {
    "terms": "{table}", "force": "{force}", "fit": "{rmse:.3g}", "tests left out": "{rmse_left_out:.3g}",
    "speeds left out": "{rmse_other_speeds:.3g}", "not separable": "{not_separable} of {coefficients}",
}  # fmt: skip


def write_reproduction(reproduced: Reproduction, path: str | Path) -> None:
    write_page(
        path, "reproduction.html.j2", title="The paper, reproduced", figures=_figures(reproduced),
        coefficients=[_coefficient(reproduced.fit, name, ours) for name, ours in reproduced.truth.coefficients.items()],
        shapley=[(name, PRINTED_SHARES[name], ours.values()) for name, ours in reproduced.shares.items()],
        kinds=KINDS, switches=reproduced.switches, printed_switch=PRINTED_SWITCH, doubts=reproduced.notes,
        source=reproduced.truth.source.text, clusters=reproduced.fit.motions.sentence, verdict=reproduced.agreement,
        voyages={y: voyage.outcome.sentence for y, voyage in reproduced.voyages.items()},
        eigenvalues={name: [f"{z.real:+.3f}{z.imag:+.3f}i" for z in ours] for name, ours in reproduced.modes.items()},
        stiffness=reproduced.stiffness,
    )  # fmt: skip


def _coefficient(fit: Fit, name: str, printed: float) -> dict[str, str]:
    low, high = fit.intervals[name]
    why = "" if low <= printed <= high else "outside the 95 % interval, as one in twenty is"
    if not fit.verdicts[name].determined:
        why = "not identifiable from these tests; the paper's number is its solver's choice"
    return coefficient_row(fit, name) | {"printed": f"{printed:g}", "why": why}


def _figures(reproduced: Reproduction) -> dict[str, dict[str, str]]:
    fit, tests, configuration = reproduced.fit, reproduced.fit.tests, reproduced.truth.configuration
    distances = {name: grounding_distance(voyages) for name, voyages in reproduced.readings.items()}
    sides = {name: voyages["side"] for name, voyages in reproduced.readings.items()}
    made: dict[str, tuple[Any, str]] = {
        "tests": (draw.motions_figure(tests), "Synthetic tests A, B (harmonic yaw) and C (harmonic sway)."),  # type: ignore[arg-type]
        "delta": (draw.delta_figure(configuration, fit.data_range.abs_y), "delta against y, and with the taper."),
        "surface": (draw.delta_surface_figure(configuration), "delta over offset and heading."),
        "correlation": (draw.correlation_figure(fit), "Correlations between the columns, and rank."),
        "forces": (draw.forces_figure(fit, tests), "Forces measured and estimated, with the bank's part."),  # type: ignore[arg-type]
        "shapley": (draw.shapley_figure(fit), "Shapley shares under three value functions."),
        "paths": (
            paths_figure(list(reproduced.voyages.values())),
            "Voyages from the starts of the table, hull corners.",
        ),
        "distance": (
            distances_figure(distances, sides, configuration), "Distance along the canal to the grounding."
        ),
    }  # fmt: skip
    return {name: figure(*drawn) for name, drawn in made.items()}
