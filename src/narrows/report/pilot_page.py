"""Steady legs: one page for the crew (where, how fast, what to expect, when to break off), and what was learned."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from narrows.base.errors import InputError
from narrows.base.results import interval, with_error
from narrows.control.steady_course import steady_course
from narrows.logbook.learned_coefficients import ON_TWINS, PRIOR, QUANTILE_95, LearnedCoefficient
from narrows.logbook.steady_legs import SteadyFit, SteadyPlan
from narrows.logbook.steady_readings import SHARED
from narrows.logbook.transits import InformationForecast
from narrows.model.model import Model
from narrows.quantities.names import KNOT
from narrows.report.fit_page import figure, write_page
from narrows.report.fit_page import figure as captioned
from narrows.report.printed_tables import print_result, table_of
from narrows.report.style import BLACK, BLUE, GREY, ORANGE, legend_below, panels

# Distance off its line at which a leg is broken off [beams].
STRAYED = 0.25


def write_pilot_page(plan: SteadyPlan, path: str | Path) -> None:
    ship = plan.model.configuration.ship
    run = max(leg.speed for leg in plan.legs) * (plan.settling + plan.conditions.leg_time)
    legs = [
        (f"{abs(leg.offset):g} m {leg.side}", f"{leg.speed / KNOT:g} kn", _turned(leg.rudder), _turned(leg.drift, 1))
        for leg in plan.legs
    ]
    write_page(
        path, "pilot.html.j2", title="Holding the ship to either side: what the bank does", plan=plan, legs=legs,
        picture_of_legs=captioned(legs_figure(plan), "The legs from above, the ship going up the page."),
        miles=run / 1852, minutes=np.ceil(plan.settling / 60), most_rudder=np.degrees(plan.most_rudder),
        strayed=STRAYED * ship.beam, foot=[plan.summary().partition("\n")[0], ON_TWINS],
    )  # fmt: skip


def _turned(angles: tuple[float, ...], digits: int = 0) -> str:
    """A range of angles by side: P to port, S to starboard."""
    low, _, high = np.degrees(angles)
    return " to ".join(f"{'P' if angle < 0 else 'S'} {abs(angle):.{digits}f}°" for angle in (low, high))


def legs_figure(plan: SteadyPlan) -> Figure:
    """Draw the canal from above, with ahead up: each leg's hull at its offset."""
    if not plan.legs:
        raise InputError("a plan without legs has no picture; its summary gives the reason")
    ship, half = plan.model.configuration.ship, plan.model.configuration.canal.width / 2
    figure, panes = panels(1, 1, 2.6, grid="")
    axes: Axes = panes[0, 0]
    for sign, side in ((-1, "port bank"), (1, "starboard bank")):
        axes.axvline(sign * half, color=BLACK, lw=4)
        ends = "right" if sign > 0 else "left"
        axes.text(sign * 0.97 * half, 0.06, side, rotation=90, va="bottom", ha=ends, fontsize=8)
    axes.axvline(0, color=GREY, lw=0.8, ls="-.")
    places = sorted({leg.offset for leg in plan.legs})
    for row, offset in enumerate(places):  # Each hull ahead of the last, so that neighbours do not overlap.
        colour = BLUE if offset > 0 else ORANGE
        hull = [(offset + across * ship.beam, row + 0.05 + 0.9 * along) for across, along in HULL]
        axes.add_patch(Polygon(hull, closed=True, facecolor=colour, edgecolor=BLACK, lw=0.8, alpha=0.85))
        numbers = ", ".join(str(i) for i, leg in enumerate(plan.legs, start=1) if leg.offset == offset)
        look: dict[str, Any] = {"ha": "center", "va": "center", "color": "white", "weight": "bold", "fontsize": 8}
        axes.text(offset, row + 0.5, numbers, **look)
    axes.set(xlim=(-1.05 * half, 1.05 * half), ylim=(-0.1, len(places) + 0.25), yticks=[])
    axes.set_xticks([-half, *places, 0, half], [f"{x:+.3g}" if x else "0" for x in (-half, *places, 0, half)])
    axes.spines["left"].set_visible(False)
    axes.set_xlabel("metres from the middle, the ship going up the page: port left, starboard right")
    return figure


# Outline of a hull: beams to starboard, and rows ahead.
HULL = ((-0.5, 0.0), (0.5, 0.0), (0.5, 0.75), (0.0, 1.0), (-0.5, 0.75))


def print_information(information: InformationForecast) -> None:
    columns = {"transits": "{transits}"} | {f"std {name}": f"{{std {name}:.2g}}" for name in information.std}
    print_result(information, table_of(columns, information.rows()))


# Coefficients before and after a record, in a table.
LEARNED = {
    "": "{name}", "before": "{before}", "after": "{after}", "95 % interval": "{interval}", "unit": "{unit}",
}  # fmt: skip


def learned_rows(
    coefficients: Mapping[str, LearnedCoefficient], truth: Mapping[str, float] | None = None
) -> list[dict[str, Any]]:
    learned = sorted((c for c in coefficients.values() if c.status != PRIOR), key=lambda c: c.std_ratio)
    return [
        {
            "name": c.name, "before": with_error(c.prior, c.prior_std), "after": with_error(c.value, c.std),
            "interval": interval(c.interval, c.std), "unit": c.unit, "verdict": c.verdict,
            "truth": truth[c.name] if truth else None,
        }
        for c in learned
    ]  # fmt: skip


def write_steady_report(fit: SteadyFit, path: str | Path) -> None:
    caption = "Steady rudder by offset, before and after the legs; the bank's coefficients with 95 % intervals."
    found = fit.to_dict()
    write_page(
        path,
        "steady.html.j2",
        title=f"{fit.prior.configuration.ship.name or 'A ship'}: coefficients from {len(fit.readings)} steady legs",
        standing=ON_TWINS,
        said=[line for line in fit.summary().splitlines() if line != ON_TWINS],
        learned=learned_rows(fit.coefficients),
        figure=figure(steady_figure(fit), caption),
        legs=found["legs"],
        shared=[row | {"words": SHARED[row["name"]][0]} for row in found["shared"]],
        notes=fit.notes,
    )


# Number of offsets of the curves, and their extent relative to the farthest leg.
OFFSETS, BESIDE = 21, 1.5
# Samples of coefficients, and quantiles of the rudder angle that are drawn.
SAMPLES, BAND = 200, (0.05, 0.5, 0.95)


def steady_figure(fit: SteadyFit) -> Figure:
    banks = [c for c in fit.coefficients.values() if c.from_bank and c.prior_std > 0]
    wide = {"gridspec_kw": {"width_ratios": (2.2, *(1.0 for _ in banks))}}
    figure, axes = panels(1, 1 + len(banks), 3.6, "y", **wide)
    _draw_rudder(axes[0, 0], fit)
    for panel, coefficient in zip(axes[0, 1:], banks, strict=True):
        for place, (value, std, colour) in enumerate(
            ((coefficient.prior, coefficient.prior_std, ORANGE), (coefficient.value, coefficient.std, BLUE))
        ):
            panel.errorbar([place], [value], yerr=[QUANTILE_95 * std], fmt="o", color=colour, capsize=4)
        panel.axhline(0, color=BLACK, lw=0.6)
        panel.set(xticks=[0, 1], xlim=(-0.6, 1.6), xticklabels=["before", "after"])
        panel.set_title(f"{coefficient.name}, 95 %")
    legend_below(figure, axes[0, 0].get_legend_handles_labels()[0])
    return figure


def _draw_rudder(axes: Axes, fit: SteadyFit) -> None:
    read, canal, ship = fit.readings.values, fit.prior.configuration.canal, fit.prior.configuration.ship
    far = min(BESIDE * float(np.abs(read["y"]).max()), 0.98 * (canal.width - ship.beam) / 2)
    y, speed, limit = np.linspace(-far, far, OFFSETS), float(read["u"].mean()), fit.prior.configuration.gear.limit_deg
    for model, colour, words in ((fit.prior, ORANGE, "before"), (fit.model, BLUE, "after")):
        low, middle, high = np.degrees(rudder_band(model, y, speed)).clip(-2 * limit, 2 * limit)
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


def rudder_band(model: Model, y: np.ndarray, u: float) -> np.ndarray:
    """Return the rudder of steady courses that 5 %, half and 95 % of the samples stay below [rad], (3, offsets)."""
    rudder = steady_course(model, y=xr.DataArray(y, dims="place"), u=u, samples=SAMPLES, seed=0)["rudder"]
    angles = rudder.transpose("place", "sample").to_numpy()
    # Where none holds it, it is the bow's turning away from the near bank that outgrew the rudder.
    beyond = np.where(y < 0, -np.inf, np.inf)[:, None]
    return np.asarray(np.quantile(np.where(np.isnan(angles), beyond, angles), BAND, axis=1, method="higher"))


def print_steady_fit(fit: SteadyFit) -> None:
    columns = {**LEARNED, "information": "{verdict}"}
    print_result(fit, table_of(columns, learned_rows(fit.coefficients), left=("", "unit", "information")))


LEGS = {
    "leg": "{leg}", "offset [m]": "{offset:+g}", "speed [kn]": "{speed:g}",
    "rudder to expect [deg]": "{rudder_low:+.0f} to {rudder_high:+.0f}",
    "drift to expect [deg]": "{drift_low:+.1f} to {drift_high:+.1f}",
}  # fmt: skip


def print_steady_plan(plan: SteadyPlan) -> None:
    columns = LEGS | {f"std {name} then": f"{{std {name}:.2g}}" for name in plan.targets}
    rows = [{"leg": number, **row} for number, row in enumerate(plan.rows(), start=1)]
    print_result(plan, table_of(columns, rows) if plan.legs else None)
