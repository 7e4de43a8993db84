"""The figure of each kind of result, that its ``plot()`` draws."""

from functools import singledispatch
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from narrows.captive.tests import CaptiveTests
from narrows.control import LinearSystem
from narrows.errors import InputError, shown
from narrows.estimation import Consistency, EstimatedTrack
from narrows.experiment_design import Plan
from narrows.identification import Comparison, Explanation, Fit
from narrows.logbook import EnvelopeChange, Foresight, LogFindings, ShipLog, SteadyFit, SteadyPlan
from narrows.manoeuvres import Trials
from narrows.model.froude import Scaled
from narrows.model.model import Model
from narrows.model.shallow_water import DepthCorrected
from narrows.model.squat import Squat
from narrows.report.envelope_chart import envelope_chart
from narrows.report.estimation_figures import consistency_figure, track_figure
from narrows.report.fit_figures import comparison_figure, intervals_figure, motions_figure
from narrows.report.log_report import findings_figure, log_figure
from narrows.report.manoeuvre_report import manoeuvres_figure
from narrows.report.model_figures import model_figure
from narrows.report.pilot_page import foresight_figure, pilot_page
from narrows.report.rules_view import rules_figure
from narrows.report.steady_report import change_figure, steady_figure
from narrows.report.style import BLACK, BLUE, ORANGE, drawing_on, panels
from narrows.report.transit_report import transit_figure
from narrows.report.voyage_figures import paths_figure, voyage_figure
from narrows.safety import OutsideRules, SafeEnvelope
from narrows.simulation.derivative import Jacobian
from narrows.simulation.sensitivities import Sensitivities
from narrows.simulation.voyage import Voyage
from narrows.studies.mikkelsen2025 import Reproduction
from narrows.warning.monitoring.watched_transit import WatchedTransit

MOST_CURVES = 5


def figure_of(result: Any, axes: Axes | None = None) -> Figure:
    """Draw a result.

    Parameters
    ----------
    result : Result
        What to draw.
    axes : Axes, optional
        Where to draw what has one panel, or its main one; a figure of its own unless given.

    Raises
    ------
    InputError
        Where nothing is drawn of its kind, or axes cannot hold it.
    """
    if axes is not None and not isinstance(axes, Axes):
        raise InputError(f"ax = {shown(axes)} is no Axes of Matplotlib; give one, as plt.subplots() makes")
    with drawing_on(axes):
        figure: Figure = _drawn(result)
    return figure


@singledispatch
def _drawn(result: Any) -> Figure:
    raise InputError(f"nothing is drawn of a {type(result).__name__}; take its data frame or dataset")


_drawn.register(Fit, intervals_figure)
_drawn.register(OutsideRules, rules_figure)
_drawn.register(SafeEnvelope, envelope_chart)
_drawn.register(EstimatedTrack, track_figure)
_drawn.register(Consistency, consistency_figure)
_drawn.register(ShipLog, log_figure)
_drawn.register(LogFindings, findings_figure)
_drawn.register(Trials, manoeuvres_figure)
_drawn.register(Voyage, voyage_figure)
_drawn.register(CaptiveTests, motions_figure)
_drawn.register(Model, model_figure)
_drawn.register(SteadyFit, steady_figure)
_drawn.register(Foresight, foresight_figure)
_drawn.register(EnvelopeChange, change_figure)
_drawn.register(WatchedTransit, transit_figure)


@_drawn.register
def _(result: Jacobian) -> Figure:
    return _eigenvalues(result.poles())


@_drawn.register
def _(result: LinearSystem) -> Figure:
    return _eigenvalues(result.eigenvalues())


def _eigenvalues(poles: np.ndarray) -> Figure:
    figure, axes = panels(1, 1, 3.2)
    axes[0, 0].plot(poles.real.ravel(), poles.imag.ravel(), "x", color=BLUE)
    axes[0, 0].axvline(0, color=BLACK, linewidth=0.7)
    axes[0, 0].set(xlabel="growth rate [1/s]; right of the line: runs away", ylabel="angular frequency [rad/s]")
    axes[0, 0].grid(alpha=0.3)
    return figure


@_drawn.register
def _(result: Sensitivities) -> Figure:
    """How far one percent more of each number moves the offset, those that move it most."""
    figure, axes = panels(1, 1, 3.2)
    for name in list(result.for_one_percent())[:MOST_CURVES]:
        axes[0, 0].plot(result.voyage.t, 0.01 * result.values[name] * result.of("y", name), label=name)
    axes[0, 0].set(xlabel="time [s]", ylabel="offset moved by one percent more [m]")
    axes[0, 0].grid(alpha=0.3)
    axes[0, 0].legend(frameon=False)
    return figure


@_drawn.register
def _(result: SteadyPlan) -> Figure:
    if not result.legs:
        raise InputError("a plan without legs has no page; its summary says why none is allowed")
    return pilot_page(result)


@_drawn.register
def _(result: Comparison) -> Figure:
    return comparison_figure(result.rows(), result.forces)


@_drawn.register
def _(result: Explanation) -> Figure:
    return comparison_figure(result.comparison.rows(), result.comparison.forces)


@_drawn.register
def _(result: Reproduction) -> Figure:
    return paths_figure(list(result.voyages.values()), result.truth.configuration)


@_drawn.register
def _(result: DepthCorrected) -> Figure:
    return _bars(dict(result.factors), "factor on the coefficient [1]")


@_drawn.register
def _(result: Scaled) -> Figure:
    ratios = {name: value / result.original.coefficients[name] for name, value in result.model.coefficients.items()
              if result.original.coefficients[name]}  # fmt: skip
    return _bars(ratios, "coefficient at the new scale over that at the old [1]", log=True)


@_drawn.register
def _(result: Squat) -> Figure:
    return _bars({f"{result.gives}, by {result.formula}": result.sinkage}, "sinkage [m]")


@_drawn.register
def _(result: Plan) -> Figure:
    """Standard errors after each run, beside those of the usual tests."""
    figure, axes = panels(1, len(result.targets), 2.6)
    for panel, name in zip(axes[0], result.targets, strict=True):
        panel.plot(range(1, len(result.runs) + 1), result.std[name], color=BLUE, marker="o", label="these runs")
        panel.axhline(result.usual[name], color=ORANGE, linestyle="--", label="as many about the centreline")
        panel.set(yscale="log", xlabel="run [-]", ylabel=f"standard error of {name}")
        panel.grid(alpha=0.3)
    axes[0, 0].legend(frameon=False)
    return figure


def _bars(values: dict[str, float], label: str, log: bool = False) -> Figure:
    figure, axes = panels(1, 1, 0.9 + 0.22 * len(values))
    axes[0, 0].barh(list(values), list(values.values()), color=BLUE, log=log)
    axes[0, 0].invert_yaxis()
    axes[0, 0].set_xlabel(label)
    axes[0, 0].grid(alpha=0.3, axis="x")
    return figure
