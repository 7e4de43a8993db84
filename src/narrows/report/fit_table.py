"""A fit in the terminal: coefficients, their limits, scores, Shapley shares."""

from collections.abc import Mapping

from rich.console import Console

from narrows.identification import Fit
from narrows.identification.bank_summary import BankSummary, summarise_bank
from narrows.identification.shapley import KINDS
from narrows.identification.verdict import IDENTIFIED, ZERO
from narrows.report.printed_tables import everything, print_notes, table_of
from narrows.results.base_results import interval, readable

# Columns of the coefficients, and their heads.
COLUMNS = {
    "": "{name}", "value": "{value}", "std. error": "{std}", "95 % interval": "{interval}", "unit": "{unit}",
    "verdict": "{verdict}",
}  # fmt: skip
# Colour of a row by its verdict.
COLOURS = {"identified": "", "zero": "", "imprecise": "yellow", "at bound": "yellow", "not separable": "magenta"}


def print_fit(
    fit: Fit, label: str = "", console: Console | None = None, answer: BankSummary | None = None, table: bool = True
) -> None:
    """Print a fit, its main result first; with --verbose all results."""
    console = console or Console(highlight=False, markup=False, soft_wrap=False)
    console.print(f"\n{heading(fit, label)}", style="bold")
    answer = answer or summarise_bank(fit)
    for sentence in answer.warnings:
        console.print(sentence, style="bold red")
    for sentence in answer.sentences:
        console.print(sentence)
    if table or everything():
        console.print()
        known = (coefficient_row(fit, name) for name in best_known_first(fit))
        console.print(table_of(COLUMNS, known, left=("", "unit"), no_wrap=True))
    if not everything():
        failed = () if fit.solution.kkt.satisfied else (kkt_sentence(fit),)
        print_notes(console, (*failed, *answer.details, *fit.notes))
        return
    for sentence in answer.details:
        console.print(sentence)
    console.print("Not determined by these tests", style="bold")
    for name, verdict in fit.verdicts.items():
        if verdict.status != IDENTIFIED:
            console.print(f"- {verdict.sentence(name)}")
    rows = ({"force": force, "fit": score, "left_out": fit.left_out[force]} for force, score in fit.scores.items())
    console.print(table_of(SCORES, rows, title="Fit, and on each distinct motion left out"))
    columns = {"": "{name}"} | {kind: f"{{{kind}:+.3f}}" for kind in KINDS}
    shares = share_rows({kind: fit.shapley(kind) for kind in KINDS})
    named = ({"name": name, **dict(zip(KINDS, own, strict=True))} for name, own in shares)
    console.print(table_of(columns, named, title="Shapley shares"))
    for note in (*fit.notes, kkt_sentence(fit)):
        console.print(note, style="dim")


def best_known_first(fit: Fit) -> list[str]:
    """Coefficients by relative uncertainty, the smallest first."""
    order = {name: i for i, name in enumerate((IDENTIFIED, ZERO))}

    def width(name: str) -> tuple[int, float]:
        verdict, (low, high) = fit.verdicts[name], fit.intervals[name]
        if not verdict.determined:
            return 3, 0.0
        return order.get(verdict.status, 2), (high - low) / max(abs(fit.coefficients[name]), 1e-300)

    return sorted(fit.terms.names, key=width)


def heading(fit: Fit, label: str) -> str:
    configuration = fit.tests.configuration
    depth = f"h/T = {configuration.canal.depth / configuration.ship.draft:.2f}" if configuration.canal.depth else ""
    return ", ".join(part for part in (configuration.ship.name, label, depth) if part)


def kkt_sentence(fit: Fit) -> str:
    """Return whether the solution is optimal, in words."""
    kkt = fit.solution.kkt
    worst = max(kkt)
    verb = "hold" if kkt.satisfied else "FAIL"
    return f"The Karush-Kuhn-Tucker conditions {verb}: largest violation {worst:.1e}, relative."


def coefficient_row(fit: Fit, name: str) -> dict[str, str]:
    """Return a coefficient with its uncertainty in words, and the class of its verdict on a page."""
    verdict, std = fit.verdicts[name], fit.std[name]
    known = (readable(fit.coefficients[name], std), readable(std, std), interval(fit.intervals[name], std))
    shown = known if verdict.determined else ("-", "-", "-")
    row = {"name": name, **dict(zip(("value", "std", "interval"), shown, strict=True))}
    kind = verdict.status.replace(" ", "-")
    style = COLOURS.get(verdict.status, "red")
    return {**row, "unit": fit.terms[name].dimension.unit, "verdict": verdict.status, "kind": kind, "style": style}


def share_rows(shares: Mapping[str, Mapping[str, Mapping[str, float]]]) -> list[tuple[str, list[float]]]:
    first = shares[KINDS[0]]
    return [(name, [shares[kind][force][name] for kind in KINDS]) for force in first for name in first[force]]


SCORES = {
    "": "{force}", "R2": "{fit.r2:.3f}", "RMSE": "{fit.rmse:.3f}", "R2 left out": "{left_out.r2:.3f}",
    "RMSE left out": "{left_out.rmse:.3f}",
}  # fmt: skip
