"""Pictures of delta, the pressure difference that the banks make."""

import numpy as np
from matplotlib.figure import Figure

from narrows.model.data_range import Range
from narrows.physics.clearance import delta, taper
from narrows.report.style import BLUE, GREEN, ORANGE, Margins, panels
from narrows.ship.particulars import Configuration


def delta_figure(configuration: Configuration, covered: Range | None) -> Figure:
    """Draw delta and its taper across the canal (the paper's fig. Delta_fun)."""
    # covered [m]
    width, beam = configuration.canal.width, configuration.ship.beam
    y = np.linspace(-1, 1, 801) * 0.97 * (width - beam) / 2
    figure, axes = panels(1, 1, 3.0, Margins())
    panel = axes[0, 0]
    if covered:
        panel.axvspan(-covered[1], covered[1], color=GREEN, alpha=0.15, label=f"data, |y| up to {covered[1]:.3g} m")
    panel.plot(y, delta(y, 1.0, width, beam), color=BLUE, label="delta")
    panel.plot(y, taper(y, width) * delta(y, 1.0, width, beam), color=ORANGE, linestyle="--", label="with taper")
    panel.set(ylim=(-4.5, 4.5), xlabel="offset y [m]", ylabel="delta [1]")
    panel.grid(alpha=0.3)
    panel.legend(frameon=False)
    return figure


def delta_surface_figure(configuration: Configuration) -> Figure:
    """Draw delta over offset and heading (the paper's fig. delta_surf), as contours that can be read off."""
    width, beam = configuration.canal.width, configuration.ship.beam
    y = np.linspace(-1, 1, 301) * 0.93 * (width - beam) / 2
    psi = np.linspace(-89, 89, 241)
    values = delta(y[None, :], np.cos(np.radians(psi))[:, None], width, beam)
    figure, axes = panels(1, 1, 3.2, Margins())
    panel = axes[0, 0]
    levels = [-4, -2, -1, -0.5, -0.2, -0.1, 0, 0.1, 0.2, 0.5, 1, 2, 4]
    filled = panel.contourf(y, psi, values, levels=levels, cmap="PuOr", extend="both", norm="symlog")
    lines = panel.contour(y, psi, values, levels=levels, colors="black", linewidths=0.5)
    panel.clabel(lines, fontsize=7, fmt="%g")
    figure.colorbar(filled, ax=panel, label="delta [1]")
    panel.set(xlabel="offset y [m]", ylabel="heading [deg]")
    return figure
