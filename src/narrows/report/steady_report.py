"""Results learned from steady legs, as one self-contained page."""

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from narrows.control import steady_course
from narrows.files import write_whole
from narrows.logbook import SteadyFit, SteadyPlan
from narrows.logbook.learned_coefficient import ON_TWINS, QUANTILE_95
from narrows.logbook.steady_legs.steady_readings import SHARED
from narrows.model.model import Model
from narrows.report.fit_page import figure, render
from narrows.report.pilot_page import LEARNED, learned_rows
from narrows.report.style import BLACK, BLUE, GREY, ORANGE, Margins, panels
from narrows.report.terminal import print_result, table_of


def write_steady_report(fit: SteadyFit, path: str | Path) -> None:
    caption = "Steady rudder by offset, before and after the legs; the bank's coefficients with 95 % intervals."
    found = fit.to_dict()
    page = render(
        "steady.html.j2",
        title=f"{fit.prior.configuration.ship.name or 'A ship'}: coefficients from {len(fit.readings)} steady legs",
        standing=ON_TWINS,
        said=[line for line in fit.summary().splitlines() if line != ON_TWINS],
        learned=learned_rows(fit.coefficients),
        figure=figure(steady_figure(fit), caption),
        direction=fit.readings.directions[0],
        legs=found["legs"],
        shared=[row | {"words": SHARED[row["name"]][0]} for row in found["shared"]],
        notes=fit.notes,
    )
    write_whole(path, page)


# Number of offsets of the curves, and their extent relative to the farthest leg.
OFFSETS, BESIDE = 21, 1.5
# Samples of coefficients, and quantiles of the rudder angle that are drawn.
SAMPLES, BAND = 200, (0.05, 0.5, 0.95)


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
