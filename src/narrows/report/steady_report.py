"""Results learned from steady legs, as one self-contained page."""

import math
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from rich.console import Console

from narrows.files import write_whole
from narrows.logbook import EnvelopeChange, SteadyFit, SteadyPlan
from narrows.logbook.envelope_change import rudder_band
from narrows.logbook.learned_coefficient import ON_TWINS, QUANTILE_95
from narrows.logbook.steady_legs.steady_readings import SHARED
from narrows.report.fit_page import figure, render
from narrows.report.pilot_page import LEARNED_HEADS, learned_rows
from narrows.report.style import BLACK, BLUE, GREY, ORANGE, Margins, panels
from narrows.report.terminal import WIDTH, console_of, print_notes, print_result, table_of, titled_table
from narrows.safety import SURE_SHARE


def write_steady_report(fit: SteadyFit, change: EnvelopeChange, path: str | Path) -> None:
    caption = "Steady rudder by offset, before and after the legs; the bank's coefficients with 95 % intervals."
    found = fit.to_dict()
    page = render(
        "steady.html.j2",
        title=f"{fit.prior.configuration.ship.name or 'A ship'}: coefficients from {len(fit.readings)} steady legs",
        standing=ON_TWINS,
        said=[line for line in fit.summary().splitlines() if line != ON_TWINS],
        learned=learned_rows(fit.coefficients),
        figure=figure(steady_figure(fit), caption),
        change_heads=CHANGE_HEADS,
        change=change_rows(change),
        changed=[*change.summary().splitlines(), change.notes[0]],
        direction=fit.readings.directions[0],
        legs=found["legs"],
        shared=[row | {"words": SHARED[row["name"]][0]} for row in found["shared"]],
        notes=fit.notes,
    )
    write_whole(path, page)


# Number of offsets of the curves, and their extent relative to the farthest leg.
OFFSETS, BESIDE = 21, 1.5


def steady_figure(fit: SteadyFit) -> Figure:
    banks = [c for c in fit.coefficients.values() if c.from_bank and c.prior_std > 0]
    wide = {"gridspec_kw": {"width_ratios": (2.2, *(1.0 for _ in banks))}}
    figure, axes = panels(1, 1 + len(banks), 3.6, Margins(bottom=0.95, top=0.25, across=0.6), "y", **wide)
    _draw_rudder(axes[0, 0], fit)
    for panel, coefficient in zip(axes[0, 1:], banks, strict=True):
        for place, (value, std, colour) in enumerate(
            ((coefficient.prior, coefficient.prior_std, ORANGE), (coefficient.value, coefficient.std, BLUE))
        ):
            panel.errorbar([place], [value], yerr=[QUANTILE_95 * std], fmt="o", color=colour, capsize=4)
        panel.axhline(0, color=BLACK, lw=0.6)
        panel.set(xticks=[0, 1], xlim=(-0.6, 1.6), xticklabels=["before", "after"])
        panel.set_title(f"{coefficient.name}, 95 %")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="lower center", ncols=3, frameon=False, fontsize=7)
    return figure


def _draw_rudder(axes: Axes, fit: SteadyFit) -> None:
    read, canal, ship = fit.readings.values, fit.prior.configuration.canal, fit.prior.configuration.ship
    far = min(BESIDE * float(np.abs(read["y"]).max()), 0.98 * (canal.width - ship.beam) / 2)
    y, speed, limit = np.linspace(-far, far, OFFSETS), float(read["u"].mean()), fit.prior.configuration.gear.limit_deg
    for model, colour, words in ((fit.prior, ORANGE, "before"), (fit.model, BLUE, "after")):
        low, middle, high = np.degrees(rudder_band(model, y, speed)).T.clip(-2 * limit, 2 * limit)
        axes.fill_between(y, low, high, color=colour, alpha=0.25, lw=0, label=f"9 cases of 10, {words}")
        axes.plot(y, middle, color=colour, lw=1.2)
    zero = np.degrees(fit.shared["rudder_zero"][0])
    axes.errorbar(
        read["y"], np.degrees(read["rudder"]) - zero, xerr=fit.readings.errors["y"],
        yerr=np.degrees(fit.readings.errors["rudder"]), fmt="o", color=BLACK, ms=4, lw=1, label="legs, less their zero",
    )  # fmt: skip
    for sign in (1, -1):
        axes.axhline(sign * limit, color=GREY, lw=1, ls="--")
    axes.set(xlabel="offset from the middle [m], starboard positive", ylabel="rudder that holds it [deg]")
    axes.set_ylim(-1.2 * limit, 1.2 * limit)
    axes.set_title(f"at {speed:.3g} m/s")
    axes.grid(alpha=0.3)


def change_figure(change: EnvelopeChange) -> Figure:
    frame, limit = change.to_dataframe(), np.degrees(change.before.data.attrs["rudder_limit"])
    figure, axes = panels(1, 2, 3.2, Margins(bottom=0.75, top=0.3, across=0.75))
    for when, colour in (("before", ORANGE), ("after", BLUE)):
        low, high = (frame[f"rudder_{end}_{when}"].clip(-2 * limit, 2 * limit) for end in ("low", "high"))
        axes[0, 0].fill_between(frame.index, low, high, color=colour, alpha=0.25, lw=0, label=f"9 cases of 10, {when}")
        axes[0, 1].plot(frame.index, 100 * frame[f"held_{when}"], color=colour, marker="o", label=when)
    axes[0, 0].set(ylabel="rudder that holds it [deg]", ylim=(-1.2 * limit, 1.2 * limit))
    axes[0, 1].set(ylabel="cases held [%]", ylim=(0, 104))
    axes[0, 1].axhline(100 * SURE_SHARE, color=GREY, lw=1, ls="--")
    for panel in axes[0]:
        panel.set(xlabel="offset from the middle [m]", title=f"at {frame['speed'].iloc[0]:.1f} knots")
        panel.legend(frameon=False, fontsize=7)
    return figure


def print_steady_fit(fit: SteadyFit, change: EnvelopeChange | None = None) -> None:
    console, words = console_of(WIDTH), "information"
    console.print(fit.summary())
    console.print(table_of((*LEARNED_HEADS, words), learned_rows(fit.coefficients), left=("", "unit", words)))
    if change is not None:
        print_change(change, console)
    print_notes(console, fit.notes)


def print_change(change: EnvelopeChange, console: Console | None = None) -> None:
    console = console or console_of()
    speed = change.rows()[0]["speed"]
    title = (
        f"The safe envelope: rudder that holds the ship (9 cases of 10 between) and cases held, at {speed:.1f} knots"
    )
    console.print(titled_table(title, CHANGE_HEADS, change_rows(change)))
    console.print(change.summary())


CHANGE_HEADS = (
    "offset [m]", "rudder before [deg]", "after [deg]", "held before", "after", "safe to, before [kn]", "after [kn]",
)  # fmt: skip


def change_rows(change: EnvelopeChange) -> list[tuple[str, ...]]:
    """Return a row for each offset: rudder interval, share of cases held and highest safe speed, before and after."""
    return [
        (f"{row['offset']:+.3g}", _band(row, "before"), _band(row, "after"), f"{100 * row['held_before']:.0f} %",
         f"{100 * row['held_after']:.0f} %", _knots(row["highest_speed_before"]), _knots(row["highest_speed_after"]))
        for row in change.rows()
    ]  # fmt: skip


def print_steady_plan(plan: SteadyPlan) -> None:
    heads = ("leg", "offset [m]", "speed [kn]", "rudder to expect [deg]", "drift to expect [deg]")
    rows = (
        (
            str(number), f"{row['offset']:+g}", f"{row['speed']:g}",
            f"{_degrees(row['rudder_low'])} to {_degrees(row['rudder_high'])}",
            f"{_degrees(row['drift_low'], 1)} to {_degrees(row['drift_high'], 1)}",
            *(f"{row[f'std {name}']:.2g}" for name in plan.targets),
        )
        for number, row in enumerate(plan.rows(), start=1)
    )  # fmt: skip
    table = table_of((*heads, *(f"std {name} then" for name in plan.targets)), rows)
    print_result(plan, table if plan.legs else None)


def _band(row: dict[str, float], when: str) -> str:
    low, high = row[f"rudder_low_{when}"], row[f"rudder_high_{when}"]
    return f"{_degrees(low, 1)} to {_degrees(high, 1)}"


def _degrees(angle: float, digits: int = 0) -> str:
    return f"{angle:+.{digits}f}" if math.isfinite(angle) else "none"


def _knots(speed: float) -> str:
    return f"{speed:.1f}" if math.isfinite(speed) else "nowhere"
