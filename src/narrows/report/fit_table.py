"""A fit in the terminal: coefficients, their limits, scores, Shapley shares."""

from rich.console import Console
from rich.table import Table
from rich.text import Text

from narrows.identification import Fit
from narrows.identification.bank_summary import BankSummary, summarise_bank
from narrows.identification.shapley import KINDS
from narrows.identification.verdict import IDENTIFIED, ZERO
from narrows.report.terminal import everything, print_notes
from narrows.results.base_results import interval, readable

MOST_PAIRS = 5
COLOURS = {
    "identified": "green", "zero": "green", "imprecise": "yellow", "at bound": "yellow", "not separable": "magenta",
}  # fmt: skip


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
        console.print(_coefficients(fit))
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
    for pair in fit.correlations[:MOST_PAIRS]:
        console.print(f"- {pair.sentence}")
    console.print(_scores(fit))
    console.print(_shares(fit))
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
    """Name a fit by its ship, condition and depth."""
    configuration = fit.tests.configuration
    depth = f"h/T = {configuration.canal.depth / configuration.ship.draft:.2f}" if configuration.canal.depth else ""
    return ", ".join(part for part in (configuration.ship.name, label, depth) if part)


def kkt_sentence(fit: Fit) -> str:
    """Return whether the solution is optimal, in words."""
    kkt = fit.solution.kkt
    worst = max(kkt.stationarity, kkt.multiplier, kkt.infeasibility)
    verb = "hold" if kkt.satisfied else "FAIL"
    return f"The Karush-Kuhn-Tucker conditions {verb}: largest violation {worst:.1e}, relative."


def _coefficients(fit: Fit) -> Table:
    table = Table(box=None, pad_edge=False)
    for header in ("", "value", "std. error", "95 % interval", "unit", ""):
        number = header in ("value", "std. error", "95 % interval")
        table.add_column(header, justify="right" if number else "left", no_wrap=True)
    for name in best_known_first(fit):
        status, std = fit.verdicts[name].status, fit.std[name]
        colour = COLOURS.get(status, "red")
        known = fit.verdicts[name].determined
        cells = (readable(fit.coefficients[name], std), readable(std, std), interval(fit.intervals[name], std))
        shown = cells if known else ("-", "-", "-")
        table.add_row(name, *shown, fit.terms[name].dimension.unit, Text(status, style=colour))
    return table


def _scores(fit: Fit) -> Table:
    out = "each distinct motion left out" if fit.split == "test" else "rows left out"
    table = Table(box=None, pad_edge=False, title=f"Fit, and on {out}", title_justify="left", title_style="bold")
    for header in ("", "R2", "RMSE", "R2 left out", "RMSE left out"):
        table.add_column(header, justify="left" if not header else "right")
    for force, score in fit.scores.items():
        other = fit.left_out[force]
        table.add_row(force, f"{score.r2:.3f}", f"{score.rmse:.3f}", f"{other.r2:.3f}", f"{other.rmse:.3f}")
    return table


def _shares(fit: Fit) -> Table:
    table = Table(box=None, pad_edge=False, title="Shapley shares", title_justify="left", title_style="bold")
    for header in ("", *KINDS):
        table.add_column(header, justify="left" if not header else "right")
    shares = {kind: fit.shapley(kind) for kind in KINDS}
    for force in ("Y", "N"):
        for name in shares["mse"].get(force, {}):
            table.add_row(name, *(f"{shares[kind][force][name]:+.3f}" for kind in KINDS))
    return table
