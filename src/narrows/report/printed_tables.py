"""Tables and results in the terminal: fits, plans, scaled and estimated models, ships and waterways."""

import math
import sys
from collections.abc import Iterable, Mapping, Sequence
from string import Formatter
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from rich.console import Console
from rich.table import Table

from narrows.base.errors import InputError
from narrows.base.results import interval, readable

if TYPE_CHECKING:  # A verb that prints one of them does not wait for the packages of the others
    import pandas as pd

    from narrows.identification import Fit
    from narrows.identification.bank_summary import BankSummary
    from narrows.identification.plan import Plan
    from narrows.model.froude import Scaled
    from narrows.model.model import Model
    from narrows.waterway import Waterway

Row = TypeVar("Row")

# Least width of the console [characters]: a narrower terminal wraps lines rather than losing digits.
WIDTH = 110
# Rows of a table and notes shown without --verbose.
MOST_ROWS, MOST_NOTES = 9, 6


def console_of(least: int = 0) -> Console:
    console = Console(highlight=False, markup=False)
    if least:
        console.width = max(console.width, least)
    return console


class _CellFormatter(Formatter):
    def format_field(self, value: Any, form: str) -> str:
        if value is None:
            return ""
        if isinstance(value, list | tuple):
            return ", ".join(self.format_field(one, form) for one in value)
        if isinstance(value, float) and not math.isfinite(value):
            return "-"
        return f"{100 * value:{form[:-1]}f} %" if form.endswith("%") else format(value, form)


def cells_of(columns: Mapping[str, str], rows: Iterable[Mapping[Any, Any]]) -> list[list[str]]:
    """Return the cells of rows; ``columns`` maps heads to formats, as ``{y:+.1f}``; ``-`` for numbers not finite."""
    cells = _CellFormatter()
    return [[cells.vformat(form, (), row).replace("- to -", "-") for form in columns.values()] for row in rows]


def table_of(
    columns: Mapping[str, str], rows: Iterable[Mapping[Any, Any]], left: Iterable[str] = ("",), no_wrap: bool = False,
    **options: Any,
) -> Table:  # fmt: skip
    """Return a table without rules: columns under ``left`` are left-aligned, all others right-aligned."""
    table = Table(box=None, pad_edge=False, title_justify="left", title_style="bold", **options)
    for head in columns:
        table.add_column(head, justify="left" if head in left else "right", no_wrap=no_wrap)
    rows = list(rows)
    for row, cells in zip(rows, cells_of(columns, rows), strict=True):
        table.add_row(*cells, style=row.get("style"))
    return table


def print_result(result: Any, *tables: Table | None) -> None:
    console = console_of(WIDTH)
    console.print(result.summary())
    for table in filter(None, tables):
        console.print(table)
    print_notes(console, result.notes)


def print_notes(console: Console, notes: Iterable[str]) -> None:
    every = list(dict.fromkeys(notes))
    shown = every if is_verbose() else every[:MOST_NOTES]
    for note in shown:
        console.print(f"- {note}", style="dim")
    if len(shown) < len(every):
        console.print(f"- {len(every) - len(shown)} more notes: add --verbose", style="dim")


def is_verbose() -> bool:
    """Return whether all rows and notes are requested: ``--verbose``, anywhere on the command line."""
    return "--verbose" in sys.argv


def thinned(rows: Sequence[Row]) -> list[Row]:
    """Return a few equally spaced rows, with the first and the last if possible; all with --verbose."""
    if is_verbose() or len(rows) <= MOST_ROWS:
        return list(rows)
    step = (len(rows) - 1) // MOST_ROWS + 1
    return list(rows[(len(rows) - 1) % step // 2 :: step])


# Longest table of coefficients that is printed without --verbose.
MOST_TERMS = 20
COLUMN = 14  # Column width of a plan [characters]
PLAN_FIELDS = ("kind", "offset", "amplitude", "period", "speed", "drift_deg", "depth")


def print_plan(plan: "Plan") -> None:
    from narrows.identification.plan import UNITS

    rows = plan.rows()
    names = [name for name in PLAN_FIELDS if any(row.get(name) is not None for row in rows)]
    columns = {"run": "{run}"}
    for name in names:
        head = name.removesuffix("_deg") + (f" [{UNITS[name]}]" if name in UNITS else "")
        columns[head] = f"{{{name}:g}}" if name in UNITS else f"{{{name}}}"
    columns |= {f"std {target}": f"{{std {target}:.2g}}" for target in plan.targets}
    console = console_of(COLUMN * len(columns))
    console.print(table_of(columns, [dict.fromkeys(names) | row | {"run": i} for i, row in enumerate(rows, start=1)]))
    console.print(f"Chosen from {plan.considered} candidate runs; the standard errors are those after each run.")
    for sentence in (*plan.summary().splitlines(), *plan.notes):
        console.print(f"- {sentence}")


SCALED_COLUMNS = {"": "{name}", "was": "{old:.4g}", "is": "{new:.4g}", "unit": "{unit}", "bis [1]": "{bis:.4g}"}


def print_scaled(scaled: "Scaled") -> None:
    console, shown = console_of(), scaled.to_dict()
    rows = ({"name": n, **shown["coefficients"][n], "bis": shown["bis"][n]} for n in _main_terms(scaled.model))
    console.print(table_of(SCALED_COLUMNS, rows, left=("", "unit"), no_wrap=True))
    _print_rest(console, scaled.model)
    console.print(shown["summary"])
    for note in scaled.notes:
        console.print(f"- {note}")


# Columns of the list of ships that fit a terminal, and their heads.
SHIP_COLUMNS = {
    "name": "{name}", "ship": "{ship}", "L [m]": "{length:g}", "B [m]": "{beam:g}", "T [m]": "{draft:g}",
    "rudder": "{rudder}", "bank": "{banks}", "measured": "{measured}",
}  # fmt: skip
ESTIMATE_COLUMNS = {"": "{index}", "estimate": "{value:.3g}", "std": "{std:.2g}", "unit": "{unit}"}


def estimate_summary(model: "Model") -> dict[str, Any]:
    table = model.to_dataframe()
    return {
        "coefficients": table[["value", "std", "unit"]].to_dict("index"),
        "summary": model.summary(),
        "notes": list(model.notes),
    }


def print_estimate(model: "Model") -> None:
    console = console_of()
    table = model.to_dataframe().loc[_main_terms(model)].rename_axis("index").reset_index()
    for note in model.notes:
        console.print(note, soft_wrap=True)
    if model.configuration.canal.depth is None:
        console.print("No depth is given: the estimate is for deep water; add --depth for a canal.", soft_wrap=True)
    console.print(table_of(ESTIMATE_COLUMNS, table.to_dict("records"), left=("", "unit"), no_wrap=True))
    _print_rest(console, model)


def print_model(model: "Model") -> None:
    heads = {"value" if head == "estimate" else head: form for head, form in ESTIMATE_COLUMNS.items()}
    rows = model.to_dataframe().loc[_main_terms(model)].rename_axis("index").reset_index().to_dict("records")
    print_result(model, table_of(heads, rows, left=("", "unit"), no_wrap=True))
    _print_rest(console_of(), model)


def _main_terms(model: "Model") -> list[str]:
    """Return the coefficients to print: those of the banks of a long table, or all."""
    banks = [term.name for term in model.terms.terms if term.from_bank]
    return banks if banks and len(model.terms) > MOST_TERMS and not is_verbose() else list(model.terms.names)


def _print_rest(console: "Console", model: "Model") -> None:
    if rest := len(model.terms) - len(_main_terms(model)):
        console.print(f"{rest} more coefficients: add --verbose")


def print_ships(table: "pd.DataFrame") -> None:
    console = console_of(WIDTH)
    rows = table.rename_axis("name").reset_index().replace({True: "yes", False: "no"}).to_dict("records")
    console.print(table_of(SHIP_COLUMNS, rows, left=("name", "ship", "rudder", "bank", "measured"), no_wrap=True))
    console.print("Each name replaces a model file; --json gives the source of each.")


NO_DEPTH = "No depth is given: voyages use that of the model; add --depth 16."
STATIONS, STATIONS_SHOWN = 2001, 11  # Cross-sections that are searched for extremes, and that are printed
# Share of the centreline below which a missing bank is not mentioned.
NEGLIGIBLE = 0.002


def waterway_summary(waterway: "Waterway", draft: float = 0.0, more: tuple[str, ...] = ()) -> dict[str, Any]:
    """Return a waterway's dimensions as plain values: metres, degrees."""
    s = np.linspace(0, waterway.line.length, STATIONS)
    here = waterway.keel_section(s, draft)
    closed = ~(here.width > 0) | (here.depth <= draft)
    if closed.any():
        index = int(closed.argmax())
        size = f"{here.width[index]:.4g} m wide and {here.depth[index]:.4g} m deep"
        raise InputError(
            f"{waterway.name}: no room for a draft of {draft:g} m at {s[index]:.0f} m along it, {size}; mend its banks "
            "or depths there"
        )
    narrow, sharpest = int(here.width.argmin()), waterway.sharpest_bend
    deep = bool(np.isfinite(here.depth).all())
    summary = {
        "name": waterway.name,
        "length": waterway.line.length,
        "narrowest": {"width": float(here.width[narrow]), "at": float(s[narrow])},
        "shallowest": {"depth": float(here.depth.min()), "at": float(s[int(here.depth.argmin())])} if deep else None,
        "sharpest": dict(zip(("radius", "at", "over"), sharpest, strict=True)) if sharpest else None,
        "stations": _stations(waterway, draft),
    }
    notes, length = list[str](), waterway.line.length
    for bank in (waterway.starboard, waterway.port):
        first, last = (0.0, length) if bank.drawn is None else bank.drawn.corners[[0, -1]]
        if first > NEGLIGIBLE * length or last < (1 - NEGLIGIBLE) * length:
            notes.append(
                f"The {bank.side} bank is drawn from {first:.0f} to {last:.0f} m along the centreline of "
                f"{length:.0f} m; beyond, its distance is assumed constant."
            )
    notes += [*(NO_DEPTH,) * (waterway.depths is None), *more]
    return {**summary, "summary": _sentence(summary, waterway), "notes": notes}


def _stations(waterway: "Waterway", draft: float) -> list[dict[str, float]]:
    s = np.linspace(0, waterway.line.length, STATIONS_SHOWN)
    here, heading = waterway.keel_section(s, draft), np.degrees(waterway.line.heading(s)) % 360
    columns = {
        "at": s, "heading": heading, "starboard": here.width / 2 + here.middle, "port": here.width / 2 - here.middle,
        "width": here.width, "depth": here.depth,
    }  # fmt: skip
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    return [dict(zip(columns, row, strict=True)) for row in rows]


STATION_COLUMNS = {
    "at [m]": "{at:.0f}", "heading [deg]": "{heading:.1f}", "to starboard [m]": "{starboard:.1f}",
    "to port [m]": "{port:.1f}", "width [m]": "{width:.1f}", "depth [m]": "{depth:.1f}",
}  # fmt: skip


def print_waterway(waterway: "Waterway", draft: float = 0.0, notes: tuple[str, ...] = ()) -> None:
    console, summary = console_of(), waterway_summary(waterway, draft, notes)
    if waterway.place:
        console.print(f"{waterway.name}: {waterway.place_check}")
    console.print(table_of(STATION_COLUMNS, summary["stations"]))
    console.print(summary["summary"])
    print_notes(console, summary["notes"])


def _sentence(summary: dict[str, Any], waterway: "Waterway") -> str:
    narrowest, place = summary["narrowest"], waterway.place and f" ({waterway.place})"
    return (
        f"{summary['name']}{place}: {summary['length']:.0f} m long; narrowest {narrowest['width']:.1f} m at "
        f"{narrowest['at']:.0f} m"
        + _extreme_text(summary["shallowest"], "depth", "shallowest")
        + _extreme_text(summary["sharpest"], "radius", "sharpest bend, radius")
    )


def _extreme_text(extreme: dict[str, float] | None, name: str, word: str) -> str:
    if extreme is None:
        return ""
    over = f" over {extreme['over']:.3g} m" if "over" in extreme else ""
    return f"; {word} {extreme[name]:.4g} m{over} at {extreme['at']:.0f} m"


# Columns of the coefficients, and their heads.
COLUMNS = {
    "": "{name}", "value": "{value}", "std. error": "{std}", "95 % interval": "{interval}", "unit": "{unit}",
    "verdict": "{verdict}",
}  # fmt: skip
# Colour of a row by its verdict.
COLOURS = {"identified": "", "zero": "", "imprecise": "yellow", "at bound": "yellow", "not separable": "magenta"}


def print_fit(
    fit: "Fit", label: str = "", console: Console | None = None, answer: "BankSummary | None" = None, table: bool = True
) -> None:
    """Print a fit, its main result first; with --verbose all results."""
    from narrows.identification.bank_summary import summarise_bank
    from narrows.identification.prediction import KINDS
    from narrows.identification.verdict import IDENTIFIED

    console = console or Console(highlight=False, markup=False, soft_wrap=False)
    console.print(f"\n{heading(fit, label)}", style="bold")
    answer = answer or summarise_bank(fit)
    for sentence in answer.warnings:
        console.print(sentence, style="bold red")
    for sentence in answer.sentences:
        console.print(sentence)
    if table or is_verbose():
        console.print()
        known = (coefficient_row(fit, name) for name in best_known_first(fit))
        console.print(table_of(COLUMNS, known, left=("", "unit"), no_wrap=True))
    if not is_verbose():
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
    console.print(table_of(SCORE_COLUMNS, rows, title="Fit, and on each distinct motion left out"))
    columns = {"": "{name}"} | {kind: f"{{{kind}:+.3f}}" for kind in KINDS}
    shares = share_rows({kind: fit.shapley(kind) for kind in KINDS})
    named = ({"name": name, **dict(zip(KINDS, row, strict=True))} for name, row in shares)
    console.print(table_of(columns, named, title="Shapley shares"))
    for note in (*fit.notes, kkt_sentence(fit)):
        console.print(note, style="dim")


def best_known_first(fit: "Fit") -> list[str]:
    """Return the coefficients: identified, zero, others, undetermined; each group by relative uncertainty."""
    from narrows.identification.verdict import IDENTIFIED, ZERO

    order = {IDENTIFIED: 0, ZERO: 1}

    def width(name: str) -> tuple[int, float]:
        verdict, (low, high) = fit.verdicts[name], fit.intervals[name]
        if not verdict.determined:
            return 3, 0.0
        return order.get(verdict.status, 2), (high - low) / max(abs(fit.coefficients[name]), 1e-300)

    return sorted(fit.terms.names, key=width)


def heading(fit: "Fit", label: str) -> str:
    configuration = fit.tests.configuration
    depth = f"h/T = {configuration.canal.depth / configuration.ship.draft:.2f}" if configuration.canal.depth else ""
    return ", ".join(part for part in (configuration.ship.name, label, depth) if part)


def kkt_sentence(fit: "Fit") -> str:
    kkt = fit.solution.kkt
    worst = max(kkt)
    verb = "hold" if kkt.satisfied else "FAIL"
    return f"The Karush-Kuhn-Tucker conditions {verb}: largest violation {worst:.1e}, relative."


def coefficient_row(fit: "Fit", name: str) -> dict[str, str]:
    """Return a coefficient with its uncertainty in words, and the class of its verdict on a page."""
    verdict, std = fit.verdicts[name], fit.std[name]
    known = (readable(fit.coefficients[name], std), readable(std, std), interval(fit.intervals[name], std))
    shown = known if verdict.determined else ("-", "-", "-")
    row = {"name": name, **dict(zip(("value", "std", "interval"), shown, strict=True))}
    kind = verdict.status.replace(" ", "-")
    style = COLOURS.get(verdict.status, "red")
    return {**row, "unit": fit.terms[name].dimension.unit, "verdict": verdict.status, "kind": kind, "style": style}


def share_rows(shares: Mapping[str, Mapping[str, Mapping[str, float]]]) -> list[tuple[str, list[float]]]:
    first = next(iter(shares.values()))
    return [(name, [share[force][name] for share in shares.values()]) for force in first for name in first[force]]


SCORE_COLUMNS = {
    "": "{force}", "R2": "{fit.r2:.3f}", "RMSE": "{fit.rmse:.3f}", "R2 left out": "{left_out.r2:.3f}",
    "RMSE left out": "{left_out.rmse:.3f}",
}  # fmt: skip
