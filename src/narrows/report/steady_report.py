"""Results learned from steady legs, as one self-contained page."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from narrows.files import write_whole
from narrows.logbook import EnvelopeChange, SteadyFit, SteadyPlan
from narrows.logbook.envelope_change import rudder_band
from narrows.logbook.learned_coefficient import ON_TWINS, QUANTILE_95
from narrows.logbook.steady_legs.steady_readings import SHARED
from narrows.report.fit_page import figure, render
from narrows.report.pilot_page import LEARNED, learned_rows
from narrows.report.style import BLACK, BLUE, GREY, ORANGE, Margins, panels
from narrows.report.terminal import WIDTH, cells_of, console_of, print_notes, print_result, table_of
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
        change_heads=[*CHANGE],
        change=cells_of(CHANGE, change.rows()),
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


def print_steady_fit(fit: SteadyFit, change: EnvelopeChange) -> None:
    console = console_of(WIDTH)
    console.print(fit.summary())
    columns = {**LEARNED, "information": "{verdict}"}
    console.print(table_of(columns, learned_rows(fit.coefficients), left=("", "unit", "information")))
    speed = change.rows()[0]["speed"]
    title = (
        f"The safe envelope: rudder that holds the ship (9 cases of 10 between) and cases held, at {speed:.1f} knots"
    )
    console.print(table_of(CHANGE, change.rows(), title=title))
    console.print(change.summary())
    print_notes(console, fit.notes)


# Rudder interval, share of cases held and highest safe speed at each offset, before and after.
CHANGE = {
    "offset [m]": "{offset:+.3g}", "rudder before [deg]": "{rudder_low_before:+.1f} to {rudder_high_before:+.1f}",
    "after [deg]": "{rudder_low_after:+.1f} to {rudder_high_after:+.1f}", "held before": "{held_before:.0%}",
    "held after": "{held_after:.0%}", "safe to, before [kn]": "{highest_speed_before:.1f}",
    "after [kn]": "{highest_speed_after:.1f}",
}  # fmt: skip
LEGS = {
    "leg": "{leg}", "offset [m]": "{offset:+g}", "speed [kn]": "{speed:g}",
    "rudder to expect [deg]": "{rudder_low:+.0f} to {rudder_high:+.0f}",
    "drift to expect [deg]": "{drift_low:+.1f} to {drift_high:+.1f}",
}  # fmt: skip


def print_steady_plan(plan: SteadyPlan) -> None:
    columns = LEGS | {f"std {name} then": f"{{std {name}:.2g}}" for name in plan.targets}
    rows = [{"leg": number, **row} for number, row in enumerate(plan.rows(), start=1)]
    print_result(plan, table_of(columns, rows) if plan.legs else None)
