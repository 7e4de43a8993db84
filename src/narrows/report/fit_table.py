"""A fit in the terminal: coefficients, their limits, scores, Shapley shares."""

from collections.abc import Mapping

from rich.console import Console
from rich.table import Table
from rich.text import Text

from narrows.identification import Fit
from narrows.identification.bank_summary import BankSummary, summarise_bank
from narrows.identification.shapley import KINDS
from narrows.identification.verdict import IDENTIFIED, ZERO
from narrows.report.terminal import everything, print_notes, table_of, titled_table
from narrows.results.base_results import interval, readable

MOST_PAIRS = 5
# Columns of the coefficients, and their heads.
COLUMNS = {
    "name": "", "value": "value", "std": "std. error", "interval": "95 % interval", "unit": "unit", "verdict": "",
}  # fmt: skip
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


def coefficient_row(fit: Fit, name: str) -> dict[str, str]:
    """Return a coefficient with its uncertainty in words, and the class of its verdict on a page."""
    verdict, std = fit.verdicts[name], fit.std[name]
    known = (readable(fit.coefficients[name], std), readable(std, std), interval(fit.intervals[name], std))
    shown = known if verdict.determined else ("-", "-", "-")
    row = {"name": name, **dict(zip(("value", "std", "interval"), shown, strict=True))}
    kind = verdict.status.replace(" ", "-")
    return {**row, "unit": fit.terms[name].dimension.unit, "verdict": verdict.status, "kind": kind}


def share_rows(shares: Mapping[str, Mapping[str, Mapping[str, float]]]) -> list[tuple[str, list[float]]]:
    """Return the Shapley shares of each term, of all kinds."""
    first = shares[KINDS[0]]
    return [(name, [shares[kind][force][name] for kind in KINDS]) for force in first for name in first[force]]


def _coefficients(fit: Fit) -> Table:
    rows = (
        [Text(row[key], style=COLOURS.get(row[key], "red") if key == "verdict" else "") for key in COLUMNS]
        for row in (coefficient_row(fit, name) for name in best_known_first(fit))
    )
    return table_of(COLUMNS.values(), rows, left=("", "unit"), no_wrap=True)


def _scores(fit: Fit) -> Table:
    out = "each distinct motion left out" if fit.split == "test" else "rows left out"
    rows = (
        (force, *(f"{number:.3f}" for one in (score, fit.left_out[force]) for number in (one.r2, one.rmse)))
        for force, score in fit.scores.items()
    )
    return titled_table(f"Fit, and on {out}", ("", "R2", "RMSE", "R2 left out", "RMSE left out"), rows)


def _shares(fit: Fit) -> Table:
    shares = share_rows({kind: fit.shapley(kind) for kind in KINDS})
    return titled_table("Shapley shares", ("", *KINDS), ((name, *map("{:+.3f}".format, own)) for name, own in shares))
