"""The reproduction page of the paper: every table and figure, with the printed numbers."""

from pathlib import Path
from typing import Any

from narrows.files import write_whole
from narrows.identification import Fit
from narrows.identification.shapley import KINDS
from narrows.report import fit_figures as draw
from narrows.report.fit_page import figure, render
from narrows.report.fit_table import coefficient_row
from narrows.report.voyage_figures import distances_figure, paths_figure
from narrows.simulation.ensemble import grounding_distance
from narrows.studies.mikkelsen2025 import PRINTED_SHARES, PRINTED_SWITCH, Reproduction


def write_reproduction(reproduced: Reproduction, path: str | Path) -> None:
    page = render(
        "reproduction.html.j2", title="The paper, reproduced", figures=_figures(reproduced),
        coefficients=[_coefficient(reproduced.fit, name, ours) for name, ours in reproduced.truth.coefficients.items()],
        shapley=[(name, PRINTED_SHARES[name], ours.values()) for name, ours in reproduced.shares.items()],
        kinds=KINDS, switches=reproduced.switches, printed_switch=PRINTED_SWITCH, doubts=reproduced.notes,
        source=reproduced.truth.source.text, clusters=reproduced.fit.motions.sentence, verdict=reproduced.agreement,
        voyages={y: voyage.outcome.sentence for y, voyage in reproduced.voyages.items()},
        eigenvalues={name: [f"{z.real:+.3f}{z.imag:+.3f}i" for z in ours] for name, ours in reproduced.modes.items()},
        stiffness=reproduced.stiffness,
    )  # fmt: skip
    write_whole(path, page)


def _coefficient(fit: Fit, name: str, printed: float) -> dict[str, str]:
    low, high = fit.intervals[name]
    why = _why(fit.verdicts[name].determined, low <= printed <= high)
    return coefficient_row(fit, name) | {"printed": f"{printed:g}", "why": why}


def _why(known: bool, inside: bool) -> str:
    if not known:
        return "not identifiable from these tests; the paper's number is its solver's choice"
    return "" if inside else "outside the 95 % interval, as one in twenty is"


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
            paths_figure(list(reproduced.voyages.values()), configuration),
            "Voyages from the starts of the table, hull corners.",
        ),
        "distance": (
            distances_figure(distances, sides, configuration), "Distance along the canal to the grounding."
        ),
    }  # fmt: skip
    return {name: figure(*drawn) for name, drawn in made.items()}
