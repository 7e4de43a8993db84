"""One self-contained page for the fits of a table, with all figures inside."""

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from narrows.base.files import write_whole
from narrows.base.results import with_error
from narrows.captive.tests import CaptiveTests
from narrows.identification import Fit
from narrows.identification.bank_summary import BankSummary, summarise_bank
from narrows.identification.shapley import KINDS
from narrows.identification.verdict import IDENTIFIED
from narrows.model.data_range import MEASURES
from narrows.model.term import Term
from narrows.quantities.names import name_of
from narrows.report import fit_figures as draw
from narrows.report.printed_tables import best_known_first, coefficient_row, heading, kkt_sentence, share_rows
from narrows.report.style import svg


def write_report(
    fits: Mapping[str, Fit], path: str | Path, title: str = "narrows", answers: Mapping[str, BankSummary] | None = None
) -> None:
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
    sections = [section(label, fit, number, answers[label]) for number, (label, fit) in enumerate(fits.items())]
    write_page(path, "fits.html.j2", title=title, sections=sections, comparison=_comparison(fits))


def write_page(path: str | Path, template: str, **values: Any) -> None:
    from jinja2 import Environment, PackageLoader, StrictUndefined

    loader = PackageLoader("narrows.report", "templates")
    environment = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True)
    write_whole(path, environment.get_template(template).render(**values))


def figure(picture: Any, caption: str) -> dict[str, str]:
    return {"svg": svg(picture), "caption": caption}


def section(label: str, fit: Fit, number: int, answer: BankSummary | None = None) -> dict[str, Any]:
    return {
        "id": f"fit-{number}",
        "heading": heading(fit, label),
        "answer": (*answer.warnings, *answer.sentences) if answer else (),
        "details": answer.details if answer else (),
        "source": fit.tests.source,
        "ship": {k: v for k, v in asdict(fit.tests.configuration.ship).items() if v is not None},
        "setting": {"width": fit.tests.configuration.canal.width, "depth": fit.tests.configuration.canal.depth,
                    "density": fit.tests.configuration.water.density},
        "envelope": [
            f"{measure.words}: {measure.describe(*pair)}"
            for name, measure in MEASURES.items() if (pair := getattr(fit.data_range, name)) is not None
        ],
        "equations": equations(fit),
        "constraints": constraints(fit),
        "coefficients": [coefficient_row(fit, name) for name in best_known_first(fit)],
        "first": _first_picture(fit),
        "predictiveness": [one.sentence for one in fit.predictiveness],
        "doubts": [verdict.sentence(name) for name, verdict in fit.verdicts.items() if verdict.status != IDENTIFIED],
        "scores": [(force, score, fit.left_out[force]) for force, score in fit.scores.items()],
        "influence": [(name, fit.influence[name].idxmax(), f"{fit.influence[name].max():.2f}")
                      for name in fit.terms.names if fit.verdicts[name].determined],
        "shapley": share_rows({kind: fit.shapley(kind) for kind in KINDS}),
        "notes": [*fit.notes, kkt_sentence(fit)],
        "figures": _figures(fit),
    }  # fmt: skip


def _first_picture(fit: Fit) -> list[dict[str, str]]:
    """Measured against predicted forces of left-out motions."""
    if not isinstance(fit.tests, CaptiveTests) or len(fit.motions) < 2:
        return []
    caption = "Measured forces against those predicted by the other motions, each motion left out in turn."
    return [figure(draw.left_out_figure(fit, fit.tests), caption)]


def equations(fit: Fit) -> list[str]:
    return [
        f"{force} = " + " + ".join(f"{term.name} {_regressor_text(term)}" for term in terms)
        for force, terms in fit.terms.forces.items()
        if terms
    ]


def _regressor_text(term: Term) -> str:
    name = name_of(term.regressor)
    return name if name.endswith(")") else f"{name}({', '.join(term.inputs)})"


def constraints(fit: Fit) -> str:
    bounded = [term.name for term in fit.terms.terms if term.bound[0] == 0]
    ties = [" = ".join(tie) for tie in fit.terms.ties]
    return "; ".join([f"{', '.join(bounded)} not negative"] * bool(bounded) + ties) or "none"


def _figures(fit: Fit) -> list[dict[str, str]]:
    tests = fit.tests
    pictures = [
        figure(draw.intervals_figure(fit), "Coefficients with their 95 % intervals, each over its own size."),
        figure(draw.correlation_figure(fit), "Correlations between the columns of each force; grey: constant."),
        figure(draw.shapley_figure(fit), "Shapley shares of the terms under three value functions."),
    ]  # fmt: skip
    if isinstance(tests, CaptiveTests):
        measured = figure(draw.forces_figure(fit, tests), "Forces measured and estimated, and the bank's part.")
        pictures = [measured, *pictures, figure(draw.motions_figure(tests), "The tests: motions and forces.")]
    return pictures


def _comparison(fits: Mapping[str, Fit]) -> dict[str, Any] | None:
    ship = list(fits.values())[-1].tests.configuration.ship
    fits = {label: fit for label, fit in fits.items() if fit.tests.configuration.ship == ship}
    if len(fits) < 2:
        return None
    names = next(iter(fits.values())).terms.names
    rows = [
        (name, [with_error(f.coefficients[name], f.std[name]) if f.verdicts[name].determined else "-"
                for f in fits.values()],
         [f.verdicts[name].status.replace(" ", "-") for f in fits.values()])
        for name in names
    ]  # fmt: skip
    return {"labels": [heading(fit, label).partition(", ")[2] for label, fit in fits.items()], "rows": rows}
