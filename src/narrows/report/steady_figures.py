"""Pictures of steady legs: rudder by offset, bank coefficients and safe envelope, each before and after."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from narrows.logbook import EnvelopeChange, SteadyFit
from narrows.logbook.envelope_change import rudder_band
from narrows.logbook.learned_coefficient import WIDE
from narrows.report.style import BLACK, BLUE, GREY, ORANGE, Margins, panels
from narrows.safety import SURE_SHARE

# Of the curves, and how far beyond the farthest leg they go.
OFFSETS, BESIDE = 21, 1.5


def steady_figure(fit: SteadyFit) -> Figure:
    """Draw the rudder that holds the ship by offset, before and after, with the legs; the bank's coefficients."""
    banks = [c for c in fit.coefficients.values() if c.from_bank and c.prior_std > 0]
    wide = {"gridspec_kw": {"width_ratios": (2.2, *(1.0 for _ in banks))}}
    figure, axes = panels(1, 1 + len(banks), 3.6, Margins(bottom=0.95, top=0.25, across=0.6), **wide)
    _draw_rudder(axes[0, 0], fit)
    for panel, coefficient in zip(axes[0, 1:], banks, strict=True):
        for place, (value, std, colour) in enumerate(
            ((coefficient.prior, coefficient.prior_std, ORANGE), (coefficient.value, coefficient.std, BLUE))
        ):
            panel.errorbar([place], [value], yerr=[WIDE * std], fmt="o", color=colour, capsize=4)
        panel.axhline(0, color=BLACK, lw=0.6)
        panel.set(xticks=[0, 1], xlim=(-0.6, 1.6), xticklabels=["before", "after"])
        panel.set_title(f"{coefficient.name}, 95 %")
        panel.grid(alpha=0.3, axis="y")
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
    """Draw what a record changes of the safe envelope: the rudder by offset, and the cases held."""
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
        panel.grid(alpha=0.3)
    return figure
