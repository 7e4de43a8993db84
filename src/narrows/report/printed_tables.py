"""Tables and results in the terminal: fits, plans, scaled and estimated models, ships and waterways."""

import math
import sys
from collections.abc import Iterable, Mapping, Sequence
from string import Formatter
from typing import TYPE_CHECKING, Any

import numpy as np

import narrows as nw
from narrows.base.errors import InputError
from narrows.base.results import interval, readable
from narrows.quantities.names import KNOT

if TYPE_CHECKING:  # A verb that prints one of them does not wait for the packages of the others
    import pandas as pd
    from rich.console import Console
    from rich.table import Table

    from narrows.identification.bank_summary import BankSummary

# Least width of the console [characters]: a narrower terminal wraps lines rather than losing digits.
WIDTH = 110
# Rows of a table and notes shown without --verbose.
MOST_ROWS, MOST_NOTES = 9, 6


def console_of(least: int = 0) -> "Console":
    from rich.console import Console

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


CELLS = _CellFormatter()


def table_of(
    columns: Mapping[str, str], rows: Iterable[Mapping[Any, Any]], left: Iterable[str] = ("",), no_wrap: bool = False,
    **options: Any,
) -> "Table":  # fmt: skip
    """Return a table without rules: columns under ``left`` are left-aligned, all others right-aligned.

    ``columns`` maps heads to formats, such as ``{y:+.1f}``; numbers that are not finite become ``-``.
    """
    from rich.table import Table

    table = Table(box=None, pad_edge=False, title_justify="left", title_style="bold", **options)
    for head in columns:
        table.add_column(head, justify="left" if head in left else "right", no_wrap=no_wrap)
    for row in rows:
        cells = (CELLS.vformat(form, (), row).replace("- to -", "-") for form in columns.values())
        table.add_row(*cells, style=row.get("style"))
    return table


def print_result(result: Any, *tables: "Table | None") -> None:
    console = console_of(WIDTH)
    console.print(result.summary())
    for table in filter(None, tables):
        console.print(table)
    print_notes(console, result.notes)


def print_notes(console: "Console", notes: Iterable[str]) -> None:
    every = list(dict.fromkeys(notes))
    shown = every if is_verbose() else every[:MOST_NOTES]
    for note in shown:
        console.print(f"- {note}", style="dim")
    if len(shown) < len(every):
        console.print(f"- {len(every) - len(shown)} more notes: add --verbose", style="dim")


def is_verbose() -> bool:
    """Return whether all rows and notes are requested: ``--verbose``, anywhere on the command line."""
    return "--verbose" in sys.argv


def thinned(rows: Sequence[Any]) -> list[Any]:
    """Return a few equally spaced rows, with the first and the last if possible; all with --verbose."""
    if is_verbose() or len(rows) <= MOST_ROWS:
        return list(rows)
    step = (len(rows) - 1) // MOST_ROWS + 1
    return list(rows[(len(rows) - 1) % step // 2 :: step])


def frame_table(frame: "pd.DataFrame", **options: Any) -> "Table":
    """Return the table of a data frame: numbers to four digits, words on the left, no column without a value."""
    frame = frame.dropna(axis=1, how="all")
    numbers = {*frame.select_dtypes("number").columns}
    columns = {str(name): f"{{c{i}:.4g}}" if name in numbers else f"{{c{i}}}" for i, name in enumerate(frame)}
    rows = [{f"c{i}": value for i, value in enumerate(row)} for row in frame.itertuples(index=False)]
    return table_of(columns, rows, left={*map(str, frame.columns)} - numbers, no_wrap=True, **options)


def print_plan(plan: "nw.Plan") -> None:
    frame = plan.to_dataframe().drop(columns=["name", "duration [s]"])
    frame.insert(0, "run", range(1, len(frame) + 1))
    print_result(plan, frame_table(frame))
    words = f"Chosen from {plan.considered} candidate runs; the standard errors are those after each run."
    console_of(WIDTH).print(words)


def print_scaled(scaled: "nw.Scaled") -> None:
    frame = scaled.to_dataframe().rename(columns={"old": "was", "new": "is"})
    frame["bis [1]"] = scaled.to_dict()["bis"]
    _print_coefficients(scaled.model, frame)
    print_result(scaled)


def print_estimate(model: "nw.Model") -> None:
    console, depth = console_of(), model.configuration.canal.depth
    deep = ("No depth is given: the estimate is for deep water; add --depth for a canal.",) if depth is None else ()
    for note in (*model.notes, *deep):
        console.print(note, soft_wrap=True)
    _print_coefficients(model)


def print_model(model: "nw.Model") -> None:
    print_result(model)
    _print_coefficients(model)


# Longest table of coefficients that is printed without --verbose.
MOST_TERMS = 20


def _print_coefficients(model: "nw.Model", frame: "pd.DataFrame | None" = None) -> None:
    """Print a table of coefficients: all, or of a long table those of the banks."""
    console, banks = console_of(), [term.name for term in model.terms.terms if term.from_bank]
    frame = model.to_dataframe()[["value", "std", "unit"]] if frame is None else frame
    shown = frame.loc[banks] if banks and len(frame) > MOST_TERMS and not is_verbose() else frame
    console.print(frame_table(shown.reset_index(names="")))
    if rest := len(frame) - len(shown):
        console.print(f"{rest} more coefficients: add --verbose")


# Columns of the list of ships that fit a terminal, and their heads.
SHIP_COLUMNS = {
    "name": "name", "ship": "ship", "length": "L [m]", "beam": "B [m]", "draft": "T [m]", "rudder": "rudder",
    "banks": "bank", "measured": "measured",
}  # fmt: skip


def print_ships(table: "pd.DataFrame") -> None:
    console, table = console_of(WIDTH), table.reset_index(names="name").rename(columns=SHIP_COLUMNS)
    console.print(frame_table(table[[*SHIP_COLUMNS.values()]].replace({True: "yes", False: "no"})))
    console.print("Each name replaces a model file; --json gives the source of each.")


CIRCLE_COLUMNS = {
    "rudder [deg]": "{order}", "advance/L": "{advance_over_length:.2f}", "transfer/L": "{transfer_over_length:.2f}",
    "tactical diameter/L": "{tactical_diameter_over_length:.2f}", "speed/approach": "{speed_over_approach:.2f}",
}  # fmt: skip
ZIGZAG_COLUMNS = {"zigzag [deg]": "{order}", "overshoots [deg]": "{overshoots_deg:.1f}"}


def print_manoeuvres(trials: "nw.Trials") -> None:
    console, results = console_of(), trials.to_dict()
    console.print(f"{trials.model.configuration.ship.name}, approach at {trials.speed:.4g} m/s, in open water")
    for columns, measured in ((CIRCLE_COLUMNS, results["turning"]), (ZIGZAG_COLUMNS, results["zigzags"])):
        console.print(table_of(columns, [{"order": order, **measures} for order, measures in measured.items()]))
    print_notes(console, trials.notes)


def print_squat(squat: "nw.Squat") -> None:
    console, columns = console_of(), {"speed [m/s]": "{u:.2f}", "[kn]": "{kn:.1f}", "sinkage [m]": "{sinkage:.2f}"}
    rows = squat.to_dataframe().assign(kn=lambda table: table["u"] / KNOT).to_dict("records")
    console.print(squat.summary())
    console.print(table_of(columns, rows))
    print_notes(console, squat.notes)


# Cross-sections that are searched for extremes, and those that are printed.
SEARCHED, PRINTED = 2001, 11
# Share of the centreline below which a missing bank is not mentioned.
NEGLIGIBLE = 0.002
# Columns of the stations along a waterway, with their units.
STATION_UNITS = {"at": "m", "heading": "deg", "starboard": "m", "port": "m", "width": "m", "depth": "m"}


def waterway_summary(waterway: "nw.Waterway", draft: float = 0.0, more: tuple[str, ...] = ()) -> dict[str, Any]:
    """Return a waterway's dimensions as plain values: metres, degrees."""
    length, words = waterway.line.length, waterway.summary()
    s = np.linspace(0, length, SEARCHED)
    here = waterway.section(s, draft)
    closed = ~(here.width > 0) | (here.depth <= draft)
    if closed.any():
        index = int(closed.argmax())
        size = f"{here.width[index]:.4g} m wide and {here.depth[index]:.4g} m deep"
        raise InputError(
            f"{waterway.name}: no room for a draft of {draft:g} m at {s[index]:.0f} m along it, {size}; mend its banks "
            "or depths there"
        )
    extremes: dict[str, dict[str, float] | None] = dict.fromkeys(("narrowest", "shallowest", "sharpest"))
    for name, what, values in (("narrowest", "width", here.width), ("shallowest", "depth", here.depth)):
        if np.isfinite(values).all():
            least, at = float(values.min()), float(s[int(values.argmin())])
            extremes[name] = {what: least, "at": at}
            words += f"; {name} {least:.4g} m at {at:.0f} m"
    if bend := waterway.sharpest_bend:
        extremes["sharpest"] = dict(zip(("radius", "at", "over"), bend, strict=True))
    drawn = {bank.side: bank.s[[0, -1]] for bank in (waterway.starboard, waterway.port) if bank.drawn}
    notes = [
        f"The {side} bank is drawn from {first:.0f} to {last:.0f} m along the centreline of {length:.0f} m; beyond, "
        "its distance is assumed constant."
        for side, (first, last) in drawn.items()
        if first > NEGLIGIBLE * length or last < (1 - NEGLIGIBLE) * length
    ]
    if waterway.depths is None:
        notes.append("No depth is given: voyages use that of the model; add --depth 16.")
    s = np.linspace(0, length, PRINTED)
    here, heading = waterway.section(s, draft), np.degrees(waterway.line.heading(s)) % 360
    sides = here.width / 2 + here.middle, here.width / 2 - here.middle
    rows = np.transpose(np.broadcast_arrays(s, heading, *sides, here.width, here.depth)).tolist()
    stations = [dict(zip(STATION_UNITS, row, strict=True)) for row in rows]
    return {"name": waterway.name, "length": length, **extremes, "stations": stations, "summary": words,
            "notes": [*notes, *more]}  # fmt: skip


def print_waterway(waterway: "nw.Waterway", draft: float = 0.0, notes: tuple[str, ...] = ()) -> None:
    console, summary = console_of(), waterway_summary(waterway, draft, notes)
    if waterway.place:
        console.print(f"{waterway.name}: {waterway.place_check}")
    columns = {f"{name} [{unit}]": f"{{{name}:.1f}}" for name, unit in STATION_UNITS.items()}
    console.print(table_of(columns, summary["stations"]))
    console.print(summary["summary"])
    print_notes(console, summary["notes"])


# Columns of the coefficients, and their heads.
COLUMNS = {
    "": "{name}", "value": "{value}", "std. error": "{std}", "95 % interval": "{interval}", "unit": "{unit}",
    "verdict": "{verdict}",
}  # fmt: skip
# Colour of a row by its verdict.
COLOURS = {"identified": "", "zero": "", "imprecise": "yellow", "at bound": "yellow", "not separable": "magenta"}


def print_fit(
    fit: "nw.Fit", label: str = "", console: "Console | None" = None, answer: "BankSummary | None" = None,
    table: bool = True,
) -> None:  # fmt: skip
    """Print a fit, its main result first; with --verbose all results."""
    from narrows.identification.bank_summary import summarise_bank

    console = console or console_of()
    console.print(f"\n{heading(fit, label)}", style="bold")
    answer = answer or summarise_bank(fit)
    for sentence in answer.warnings:
        console.print(sentence, style="bold red")
    for sentence in answer.sentences:
        console.print(sentence)
    if table or is_verbose():
        console.print()
        known = (coefficient_row(fit, name) for name in surest_first(fit))
        console.print(table_of(COLUMNS, known, left=("", "unit"), no_wrap=True))
    if not is_verbose():
        failed = () if fit.solution.kkt.satisfied else (kkt_sentence(fit),)
        print_notes(console, (*failed, *answer.details, *fit.notes))
        return
    for sentence in answer.details:
        console.print(sentence)
    console.print("Not determined by these tests", style="bold")
    for name, verdict in fit.verdicts.items():
        if verdict != "identified":
            console.print(f"- {verdict.sentence(name)}")
    rows = ({"force": force, "fit": score, "left_out": fit.left_out[force]} for force, score in fit.scores.items())
    console.print(table_of(SCORE_COLUMNS, rows, title="Fit, and on each distinct motion left out"))
    shares = ({"name": name, "share": share} for part in fit.shapley().values() for name, share in part.items())
    console.print(table_of({"": "{name}", "share": "{share:+.3f}"}, shares, title="Shapley shares"))
    for note in (*fit.notes, kkt_sentence(fit)):
        console.print(note, style="dim")


def surest_first(fit: "nw.Fit") -> list[str]:
    """Return the coefficients: identified, zero, others, undetermined; each group by relative uncertainty."""
    order = {"identified": 0, "zero": 1}

    def rank(name: str) -> tuple[int, float]:
        verdict, (low, high) = fit.verdicts[name], fit.intervals[name]
        width = (high - low) / max(abs(fit.coefficients[name]), 1e-300)
        return (order.get(verdict.status, 2), width) if verdict.determined else (3, 0.0)

    return sorted(fit.terms.names, key=rank)


def heading(fit: "nw.Fit", label: str) -> str:
    configuration = fit.tests.configuration
    depth = f"h/T = {configuration.canal.depth / configuration.ship.draft:.2f}" if configuration.canal.depth else ""
    return ", ".join(part for part in (configuration.ship.name, label, depth) if part)


def kkt_sentence(fit: "nw.Fit") -> str:
    kkt = fit.solution.kkt
    verb = "hold" if kkt.satisfied else "FAIL"
    return f"The Karush-Kuhn-Tucker conditions {verb}: largest violation {max(kkt):.1e}, relative."


def coefficient_row(fit: "nw.Fit", name: str) -> dict[str, str]:
    """Return a coefficient with its uncertainty in words, and the class of its verdict on a page."""
    verdict, std = fit.verdicts[name], fit.std[name]
    known = (readable(fit.coefficients[name], std), readable(std, std), interval(fit.intervals[name], std))
    shown = known if verdict.determined else ("-", "-", "-")
    return {
        "name": name, **dict(zip(("value", "std", "interval"), shown, strict=True)),
        "unit": fit.terms[name].dimension.unit, "verdict": verdict.status,
        "kind": verdict.status.replace(" ", "-"), "style": COLOURS.get(verdict.status, "red"),
    }  # fmt: skip


SCORE_COLUMNS = {
    "": "{force}", "R2": "{fit.r2:.3f}", "RMSE": "{fit.rmse:.3f}", "R2 left out": "{left_out.r2:.3f}",
    "RMSE left out": "{left_out.rmse:.3f}",
}  # fmt: skip


def apart_rows(explanation: "nw.Explanation") -> list[dict[str, Any]]:
    own = {name: {"model": f"{explanation.model.coefficients[name]:.4g}", "apart": explanation.z_scores[name]}
           for name in explanation.fit.terms.names}  # fmt: skip
    return [coefficient_row(explanation.fit, name) | row for name, row in own.items()]


APART = {
    "": "{name}", "model": "{model}", "these tests": "{value}", "95 % interval": "{interval}",
    "apart [std. errors]": "{apart:+.1f}", "unit": "{unit}",
}  # fmt: skip


def print_explanation(explanation: "nw.Explanation", label: str = "") -> None:
    console = console_of(WIDTH)
    for sentence in (*explanation.summary().splitlines(), *explanation.notes):
        console.print(f"- {sentence}")
    rows = apart_rows(explanation)
    console.print(table_of(APART, rows, left=("", "unit"), no_wrap=True, title="The model and these tests"))
    print_fit(explanation.fit, label)
    print_comparison(explanation.comparison)


def print_comparison(comparison: "nw.Comparison") -> None:
    console, title = console_of(WIDTH), "Tables of terms by their error (RMSE) on left-out tests"
    console.print(frame_table(comparison.to_dataframe().reset_index(), title=title))
    for sentence in comparison.summary().splitlines():
        console.print(f"- {sentence}")


def print_linear(linear: "nw.control.LinearSystem") -> None:
    console = console_of(WIDTH)
    console.print(linear.summary())
    modes = {"growth [1/s]": "growth", "frequency [rad/s]": "angular_frequency", "doubling [s]": "doubling_s",
             "halving [s]": "halving_s", "period [s]": "period_s"}  # fmt: skip
    columns = {head: f"{{{name}:.4g}}" for head, name in modes.items()}
    console.print(table_of(columns, linear.modes().to_dict("records"), title="Modes"))
    print_notes(console, linear.notes)
