"""Pages, figures and tables of a model that learns from a log and from steady legs, with the pilot's page."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import narrows as nw
from narrows.base.results import interval, with_error
from narrows.logbook.learned_coefficients import ON_TWINS, PRIOR, QUANTILE_95, LearnedCoefficient
from narrows.logbook.steady_readings import SHARED
from narrows.quantities.names import KNOT
from narrows.report.colours import BLACK, BLUE, GREY, ORANGE
from narrows.report.fit_page import figure, write_page
from narrows.report.printed_tables import frame_table, print_result, table_of
from narrows.report.style import legend_below, panels

DEGREES = 180 / np.pi
# Errors of forecasts: state, words, factor.
MISSED = (("y", "offset [m]", 1.0), ("psi", "heading [deg]", DEGREES), ("r", "yaw rate [deg/s]", DEGREES))


def write_log_report(fit: nw.LogFit, path: str | Path) -> None:
    caption = "Coefficients after the log, in standard deviations before it, with 95 % intervals."
    # Coefficients whose records are compared: those of the bank, or those with the best information.
    known = [c for c in fit.coefficients.values() if c.name in fit.records[0].information]
    informed = [c.name for c in known if c.from_bank]
    informed = informed or [c.name for c in sorted(known, key=lambda c: c.std_ratio)[:3]]
    records = [
        {
            "name": record.name, "minutes": f"{record.duration / 60:.3g}",
            "missed": ["{:.2g} to {:.2g}".format(*(factor * error for error in record.forecast_rmse[name]))
                       for name, _, factor in MISSED],
            "information": [f"{100 * record.information[name]:.0f} %" for name in informed],
        }
        for record in fit.records
    ]  # fmt: skip
    write_page(
        path, "log_fit.html.j2", title=f"{fit.prior.configuration.ship.name or 'A ship'}: learned from its own log",
        said=fit.summary().splitlines(), learned=learned_rows(fit.coefficients),
        figure=figure(log_fit_figure(fit), caption), missed_heads=[words for _, words, _ in MISSED], records=records,
        informed=informed, notes=[note for note in fit.notes if note != ON_TWINS],
    )  # fmt: skip


# Largest number of drawn coefficients.
MOST_ROWS = 24


def log_fit_figure(fit: nw.LogFit) -> Figure:
    known = sorted((c for c in fit.coefficients.values() if c.prior_std > 0), key=lambda c: c.std_ratio)[:MOST_ROWS]
    figure, ((panel,),) = panels(1, 1, max(2.8, 0.9 + 0.2 * len(known)))
    panel.axvspan(-QUANTILE_95, QUANTILE_95, color=GREY, alpha=0.15, lw=0)
    panel.axvline(0, color=BLACK, lw=0.6)
    moved, wide = ([(c.value - c.prior) / c.prior_std for c in known], [QUANTILE_95 * c.std_ratio for c in known])
    panel.errorbar(moved, range(len(known)), xerr=wide, fmt="o", color=BLUE, capsize=3, ms=4)
    panel.set(xlabel="change, in prior standard deviations (grey: 95 % before)")
    panel.set_yticks(range(len(known)), [c.name for c in known])
    panel.invert_yaxis()
    return figure


# Distance off its line at which a leg is broken off [beams].
STRAYED = 0.25


def write_pilot_page(plan: nw.SteadyPlan, path: str | Path) -> None:
    ship = plan.model.configuration.ship
    run = KNOT * max(leg["speed"] for leg in plan.legs) * (plan.settling + plan.conditions.leg_time)
    legs = [
        (f"{abs(leg['offset']):g} m {leg['side']}", f"{leg['speed']:g} kn",
         _turned(leg["rudder_low"], leg["rudder_high"]), _turned(leg["drift_low"], leg["drift_high"], 1))
        for leg in plan.legs
    ]  # fmt: skip
    write_page(
        path, "pilot.html.j2", title="Holding the ship to either side: what the bank does", plan=plan, legs=legs,
        miles=run / 1852, minutes=np.ceil(plan.settling / 60), most_rudder=np.degrees(plan.most_rudder),
        strayed=STRAYED * ship.beam, foot=[plan.summary().partition("\n")[0], ON_TWINS],
    )  # fmt: skip


def _turned(low: float, high: float, digits: int = 0) -> str:
    """A range of angles [deg] by side: P to port, S to starboard."""
    return " to ".join(f"{'P' if angle < 0 else 'S'} {abs(angle):.{digits}f}°" for angle in (low, high))


def print_information(information: nw.InformationForecast) -> None:
    print_result(information, frame_table(information.to_dataframe()))


def learned_rows(coefficients: Mapping[str, LearnedCoefficient]) -> list[dict[str, Any]]:
    learned = sorted((c for c in coefficients.values() if c.status != PRIOR), key=lambda c: c.std_ratio)
    return [
        {
            "name": c.name, "before": with_error(c.prior, c.prior_std), "after": with_error(c.value, c.std),
            "interval": interval(c.interval, c.std), "unit": c.unit, "verdict": c.verdict,
        }
        for c in learned
    ]  # fmt: skip


def write_steady_report(fit: nw.SteadyFit, path: str | Path) -> None:
    caption = "Steady rudder by offset, before and after the legs; the bank's coefficients with 95 % intervals."
    found, name = fit.to_dict(), fit.prior.configuration.ship.name or "A ship"
    write_page(
        path, "steady.html.j2", title=f"{name}: coefficients from {len(fit.readings)} steady legs", standing=ON_TWINS,
        said=[line for line in fit.summary().splitlines() if line != ON_TWINS], learned=learned_rows(fit.coefficients),
        figure=figure(steady_figure(fit), caption), legs=found["legs"], notes=fit.notes,
        shared=[row | {"words": SHARED[row["name"]][0]} for row in found["shared"]],
    )  # fmt: skip


# Number of offsets of the curves, and their extent relative to the farthest leg.
OFFSETS, BESIDE = 21, 1.5
# Samples of coefficients, and quantiles of the rudder angle that are drawn.
SAMPLES, BAND = 200, (0.05, 0.5, 0.95)


def steady_figure(fit: nw.SteadyFit) -> Figure:
    banks = [c for c in fit.coefficients.values() if c.from_bank and c.prior_std > 0]
    figure, axes = panels(1, 1 + len(banks), 3.6, "y", width_ratios=(2.2, *(1.0 for _ in banks)))
    _draw_rudder(axes[0, 0], fit)
    for panel, c in zip(axes[0, 1:], banks, strict=True):
        for place, (value, std, colour) in enumerate(((c.prior, c.prior_std, ORANGE), (c.value, c.std, BLUE))):
            panel.errorbar([place], [value], yerr=[QUANTILE_95 * std], fmt="o", color=colour, capsize=4)
        panel.axhline(0, color=BLACK, lw=0.6)
        panel.set(xticks=[0, 1], xlim=(-0.6, 1.6), xticklabels=["before", "after"])
        panel.set_title(f"{c.name}, 95 %")
    legend_below(figure, axes[0, 0].get_legend_handles_labels()[0])
    return figure


def _draw_rudder(axes: Axes, fit: nw.SteadyFit) -> None:
    read, canal, ship = fit.readings.values, fit.prior.configuration.canal, fit.prior.configuration.ship
    far = min(BESIDE * float(np.abs(read["y"]).max()), 0.98 * (canal.width - ship.beam) / 2)
    y, speed, limit = np.linspace(-far, far, OFFSETS), float(read["u"].mean()), fit.prior.configuration.gear.limit_deg
    for model, colour, words in ((fit.prior, ORANGE, "before"), (fit.model, BLUE, "after")):
        low, middle, high = np.degrees(rudder_band(model, y, speed)).clip(-2 * limit, 2 * limit)
        axes.fill_between(y, low, high, color=colour, alpha=0.25, lw=0, label=f"9 cases of 10, {words}")
        axes.plot(y, middle, color=colour, lw=1.2)
    rudder, errors = np.degrees(read["rudder"] - fit.shared["rudder_zero"][0]), fit.readings.errors
    axes.errorbar(
        read["y"], rudder, xerr=errors["y"], yerr=np.degrees(errors["rudder"]), fmt="o", color=BLACK, ms=4, lw=1,
        label="legs, less their zero",
    )  # fmt: skip
    for sign in (1, -1):
        axes.axhline(sign * limit, color=GREY, lw=1, ls="--")
    axes.set(xlabel="offset from the middle [m], starboard positive", ylabel="rudder that holds it [deg]")
    axes.set_ylim(-1.2 * limit, 1.2 * limit)
    axes.set_title(f"at {speed:.3g} m/s")
    axes.grid(alpha=0.3)


def rudder_band(model: nw.Model, y: np.ndarray, u: float) -> np.ndarray:
    """Return the rudder of steady courses that 5 %, half and 95 % of the samples stay below [rad], (3, offsets)."""
    rudder = nw.steady_course(model, y=xr.DataArray(y, dims="place"), u=u, samples=SAMPLES, seed=0)["rudder"]
    angles = rudder.transpose("place", "sample").to_numpy()
    # Where none holds it, it is the bow's turning away from the near bank that outgrew the rudder.
    beyond = np.where(y < 0, -np.inf, np.inf)[:, None]
    return np.asarray(np.quantile(np.where(np.isnan(angles), beyond, angles), BAND, axis=1, method="higher"))


def print_learned(fit: nw.LogFit | nw.SteadyFit, verdict: str) -> None:
    columns = {
        "": "{name}", "before": "{before}", "after": "{after}", "95 % interval": "{interval}", "unit": "{unit}",
        verdict: "{verdict}",
    }  # fmt: skip
    print_result(fit, table_of(columns, learned_rows(fit.coefficients), left=("", "unit", verdict)))


def print_steady_plan(plan: nw.SteadyPlan) -> None:
    columns = {
        "leg": "{leg}", "offset [m]": "{offset:+g}", "speed [kn]": "{speed:g}",
        "rudder to expect [deg]": "{rudder_low:+.0f} to {rudder_high:+.0f}",
        "drift to expect [deg]": "{drift_low:+.1f} to {drift_high:+.1f}",
        **{f"std {name} then": f"{{std {name}:.2g}}" for name in plan.std},
    }  # fmt: skip
    rows = [{"leg": number, **row} for number, row in enumerate(plan.rows(), start=1)]
    print_result(plan, table_of(columns, rows) if plan.legs else None)
