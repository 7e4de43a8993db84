"""Self-contained pages of fits, of a model on a table of tests, and of the reproduction."""

from collections.abc import Mapping
from dataclasses import asdict
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

import narrows as nw
from narrows.base.files import write_whole
from narrows.base.results import with_error
from narrows.identification.bank_summary import BankSummary, summarise_bank
from narrows.model.data_range import MEASURES
from narrows.quantities.names import FORCES, name_of
from narrows.report import fit_figures as draw
from narrows.report.printed_tables import apart_rows, coefficient_row, heading, kkt_sentence, surest_first
from narrows.report.style import FONT
from narrows.report.voyage_figures import distances_figure, paths_figure
from narrows.studies.mikkelsen2025 import PRINTED_SHARES, PRINTED_SWITCH, Reproduction


def write_report(
    fits: Mapping[str, nw.Fit], path: str | Path, title: str = "narrows",
    answers: Mapping[str, BankSummary] | None = None,
) -> None:  # fmt: skip
    """Write one HTML file with all results of some fits, their main results first.

    Raises an InputError if the file cannot be written.

    Parameters
    ----------
    fits : mapping of str to Fit
        Fits by condition.
    path : str or Path
        Output file.
    title : str
        Title of the page.
    answers : mapping of str to BankSummary, optional
        Main results by condition, if computed already.
    """
    answers = answers or {label: summarise_bank(fit) for label, fit in fits.items()}
    sections = [_section(label, fit, number, answers[label]) for number, (label, fit) in enumerate(fits.items())]
    write_page(path, "fits.html.j2", title=title, sections=sections, comparison=_comparison(fits))


def write_page(path: str | Path, template: str, **values: Any) -> None:
    from jinja2 import Environment, PackageLoader, StrictUndefined

    loader = PackageLoader("narrows.report", "templates")
    environment = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True)
    write_whole(path, environment.get_template(template).render(**values))


def figure(picture: Figure, caption: str) -> dict[str, str]:
    memory = StringIO()
    with rc_context(FONT):
        picture.savefig(memory, format="svg", dpi=100, metadata={"Date": None})
    text = memory.getvalue()
    return {"svg": text[text.index("<svg") :], "caption": caption}


def _section(label: str, fit: nw.Fit, number: int, answer: BankSummary | None = None) -> dict[str, Any]:
    (first, pictures), bounded = _pictures(fit), [term.name for term in fit.terms.terms if term.bound[0] == 0]
    return {
        "id": f"fit-{number}",
        "heading": heading(fit, label),
        "answer": (*answer.warnings, *answer.sentences) if answer else (),
        "details": answer.details if answer else (),
        "fit": fit,
        "ship": {k: v for k, v in asdict(fit.tests.configuration.ship).items() if v is not None},
        "envelope": [f"{one.words}: {fit.data_range.describe(name)}" for name, one in MEASURES.items()
                     if getattr(fit.data_range, name)],
        "equations": [f"{force} = " + " + ".join(map(_term_text, terms))
                      for force, terms in fit.terms.forces.items() if terms],
        "constraints": "; ".join([f"{', '.join(bounded)} not negative"] * bool(bounded)
                                 + [" = ".join(tie) for tie in fit.terms.ties]) or "none",
        "coefficients": [coefficient_row(fit, name) for name in surest_first(fit)],
        "first": first,
        "doubts": [verdict.sentence(name) for name, verdict in fit.verdicts.items() if verdict != "identified"],
        "influence": [(name, fit.influence[name].idxmax(), f"{fit.influence[name].max():.2f}")
                      for name in fit.terms.names if fit.verdicts[name].determined],
        "shapley": fit.shapley(),
        "notes": [*fit.notes, kkt_sentence(fit)],
        "figures": pictures,
    }  # fmt: skip


def _pictures(fit: nw.Fit) -> tuple[list[dict[str, str]], list[dict[str, str]]]:
    """Return the first picture of a page, if there are rows and other motions, and the others."""
    pictures = [
        figure(draw.intervals_figure(fit), "Coefficients with their 95 % intervals, each over its own size."),
        figure(draw.correlation_figure(fit), "Correlations between the columns of each force; grey: constant."),
    ]
    if not isinstance(fit.tests, nw.CaptiveTests):
        return [], pictures
    measured = figure(draw.forces_figure(fit, fit.tests), "Forces measured and estimated, and the bank's part.")
    motions = figure(draw.motions_figure(fit.tests), "The tests: motions and forces.")
    caption = "Measured forces against those predicted by the other motions, each motion left out in turn."
    first = [figure(draw.left_out_figure(fit, fit.tests), caption)] if len(fit.motions) > 1 else []
    return first, [measured, *pictures, motions]


def _term_text(term: nw.Term) -> str:
    name = name_of(term.regressor)
    return f"{term.name} {name}" if name.endswith(")") else f"{term.name} {name}({', '.join(term.inputs)})"


def _comparison(fits: Mapping[str, nw.Fit]) -> dict[str, Any] | None:
    ship = list(fits.values())[-1].tests.configuration.ship
    fits = {label: fit for label, fit in fits.items() if fit.tests.configuration.ship == ship}
    if len(fits) < 2:
        return None
    rows = [
        (name, [with_error(f.coefficients[name], f.std[name]) if f.verdicts[name].determined else "-"
                for f in fits.values()],
         [f.verdicts[name].status.replace(" ", "-") for f in fits.values()])
        for name in next(iter(fits.values())).terms.names
    ]  # fmt: skip
    return {"labels": [heading(fit, label).partition(", ")[2] for label, fit in fits.items()], "rows": rows}


def write_explanation(explanation: nw.Explanation, path: str | Path, title: str) -> None:
    compared, caption = explanation.comparison, "Errors of tables of terms, of the fit and on left-out tests."
    write_page(
        path, "explanation.html.j2", title=title, explanation=explanation, coefficients=apart_rows(explanation),
        units={force: quantity.unit for force, quantity in FORCES.items()},
        comparison=figure(draw.comparison_figure(compared), caption),
        rows=[row | {"said": "; ".join(map(_said, row["bank"], row["bank"].values()))} for row in compared.rows()],
        s=_section("", explanation.fit, 0) | {"heading": f"A fit to these tests: {heading(explanation.fit, '')}"},
    )  # fmt: skip


def _said(name: str, coefficient: dict[str, Any]) -> str:
    low, high = coefficient["ci95"]
    known = f" {low:.3g} to {high:.3g}" if np.isfinite([low, high]).all() else ""
    return f"{name}{known} ({coefficient['verdict']})"


def write_reproduction(reproduced: Reproduction, path: str | Path) -> None:
    fit, tests, configuration = reproduced.fit, reproduced.fit.tests, reproduced.truth.configuration
    assert isinstance(tests, nw.CaptiveTests)
    made = {
        "tests": (draw.motions_figure(tests), "Synthetic tests A, B (harmonic yaw) and C (harmonic sway)."),
        "delta": (draw.delta_figure(configuration, fit.data_range.abs_y), "delta against y, and with the taper."),
        "surface": (draw.delta_surface_figure(configuration), "delta over offset and heading."),
        "correlation": (draw.correlation_figure(fit), "Correlations between the columns, and rank."),
        "forces": (draw.forces_figure(fit, tests), "Forces measured and estimated, with the bank's part."),
        "paths": (paths_figure(reproduced), "Voyages from the starts of the table, hull corners."),
        "distance": (distances_figure(reproduced), "Distance along the canal to the grounding."),
    }
    write_page(
        path, "reproduction.html.j2", title="The paper, reproduced",
        figures={name: figure(*drawn) for name, drawn in made.items()},
        coefficients=[_coefficient(fit, name, ours) for name, ours in reproduced.truth.coefficients.items()],
        shapley=[(name, PRINTED_SHARES[name], ours) for name, ours in reproduced.shares.items()],
        switches=reproduced.switches, printed_switch=PRINTED_SWITCH, doubts=reproduced.notes,
        source=reproduced.truth.source.text, clusters=fit.motions.sentence,
        voyages={y: voyage.outcome.sentence for y, voyage in reproduced.voyages.items()},
        eigenvalues={name: [f"{z.real:+.3f}{z.imag:+.3f}i" for z in ours] for name, ours in reproduced.modes.items()},
        stiffness=reproduced.stiffness,
    )  # fmt: skip


def _coefficient(fit: nw.Fit, name: str, printed: float) -> dict[str, str]:
    low, high = fit.intervals[name]
    why = "" if low <= printed <= high else "outside the 95 % interval, as one in twenty is"
    if not fit.verdicts[name].determined:
        why = "not identifiable from these tests; the paper's number is its solver's choice"
    return coefficient_row(fit, name) | {"printed": f"{printed:g}", "why": why}
