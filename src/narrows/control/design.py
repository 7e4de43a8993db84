"""Tune the weights of a regulator by simulated voyages of sampled ships, and test them on other ships (Monte Carlo)."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import count
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.control.design_trials import DesignTrials, Scene, ScenePush, TrialResult
from narrows.control.regulator import regulator
from narrows.control.regulator_gains import DEFAULT_WEIGHTS, RegulatorWeights
from narrows.control.regulator_law import Regulator
from narrows.control.settings import (
    DESIGN_JUDGES,
    DESIGN_STEP,
    DESIGNS_A_ROUND,
    FULL_TRAVEL,
    OFF_SHARE,
    TRAVEL_SHARE,
    TRIAL_LENGTHS,
)
from narrows.control.steady_course import check_rudder
from narrows.errors import InputError, check_count
from narrows.model.model import Model
from narrows.progress import bar
from narrows.results import BaseSummary
from narrows.ship.actuators import SteeringGear
from narrows.simulation.inputs import finite_numbers

if TYPE_CHECKING:
    import pandas as pd

SIX, FIVE = math.radians(6.0), math.radians(5.0)
# Test scenes: an offset, a bank that recedes twice, gusts, and a gust and a receding bank far off the centreline.
SCENES = {
    "offset": Scene(0.8, 0.3),
    "bank": Scene(1.0, 0.0, (ScenePush(2.0, 3.5, 0.0, SIX), ScenePush(5.9, 7.4, 0.0, -SIX))),
    "gust": Scene(0.8, 0.0, (ScenePush(2.0, 3.2, SIX, FIVE), ScenePush(5.9, 7.0, -SIX, -FIVE))),
    "hard": Scene(1.3, 0.0, (ScenePush(2.0, 3.2, 1.5 * SIX, 1.5 * FIVE), ScenePush(4.9, 6.1, 0.0, FIVE))),
}
# Tuned weights, as logarithms; the share of the bank is tuned on its own scale.
TUNED = ("heading_deg", "rudder_deg", "stroke_time", "integral_time", "unwinding_time")


@dataclass(frozen=True, repr=False)
class RegulatorDesign(BaseSummary):
    """A regulator designed by simulation; the result of ``design``.

    Parameters
    ----------
    model : Model
        The ship.
    y : float [m]
        Design offset.
    u : float [m/s]
        Surge velocity.
    weights : RegulatorWeights
        Weights with the lowest cost: lost ships, late offset and rudder travel.
    judged : mapping of str to mapping
        By scene: the shares of other ships that are ``lost``, the same with the default weights (``usual``), and the
        median ``travel`` of the rudder of both [rad].
    """

    model: Model
    y: float
    u: float
    weights: RegulatorWeights
    judged: Mapping[str, Mapping[str, float]]

    @property
    def regulator(self) -> Regulator:
        """The regulator at the design offset and speed."""
        return regulator(self.model, self.y, self.u, weights=self.weights)

    def to_dataframe(self) -> "pd.DataFrame":
        """Return the test results, one row per scene."""
        import pandas as pd

        return pd.DataFrame.from_dict({name: dict(row) for name, row in self.judged.items()}, orient="index")

    def summary(self) -> str:
        """Return the shares of lost ships, also with the default weights."""
        parts = [f"{name} {1000 * row['lost']:.0f} ({1000 * row['usual']:.0f})" for name, row in self.judged.items()]
        lost = f"Ships lost per 1000 test ships (default weights in brackets): {', '.join(parts)}."
        return " ".join([lost, *self.model.notes])


def design(
    model: Model, y: float, u: float, *, gear: SteeringGear | None = None, noise: Mapping[str, float] | None = None,
    ships: int = 200, rounds: int = 20, seed: int = 0, progress: bool = False,
) -> RegulatorDesign:  # fmt: skip
    """Tune the weights of a regulator by simulated voyages of sampled ships, with the gear's delays and noise.

    Ships with coefficients from the model's covariance sail four scenes: an offset, a receding bank, gusts, and both
    far off the centreline. A ship is lost if it meets a bank, or if it is still half a beam off its line at the end.
    The objective is the share of lost ships, plus small shares for the late offset and the rudder travel. The result is
    tested on other ships.

    Parameters
    ----------
    model : Model
        A model with terms of a rudder and the covariance of its coefficients.
    y : float [m]
        Offset to hold, to starboard of the centreline.
    u : float [m/s]
        Surge velocity through the water.
    gear : SteeringGear, optional
        Steering gear; the model's own unless given.
    noise : mapping of str to float, optional
        Standard deviations of the regulator's readings: y [m], psi [rad], v [m/s], r [rad/s].
    ships : int
        Number of ships for tuning; ten times as many are used for testing.
    rounds : int
        Rounds of the search, twelve designs each.
    seed : int
        Seed of all random numbers.
    progress : bool
        Show a bar on stderr.

    Returns
    -------
    RegulatorDesign
        Weights, the regulator, and its share of lost test ships.

    Raises
    ------
    InputError
        If the model has no rudder or no covariance, or a number is out of range.

    References
    ----------
    Nelder and Mead (1965), A simplex method for function minimization, The Computer Journal 7(4), 308-313.
    """
    check_rudder(model)
    if model.covariance is None:
        raise InputError("a design draws ships from the covariance of the coefficients; identify the model from tests")
    finite_numbers(y=y, u=u, **(noise or {}))
    check_count("ships", ships, 10)
    check_count("rounds", rounds, 1)
    check_count("seed", seed)
    geared = model if gear is None else with_gear(model, gear)
    scenes = tuple(SCENES.values())
    trials = DesignTrials(geared, y, u, scenes, ships, seed, noise)

    def cost(point: np.ndarray) -> float:
        weights = weights_at(point)
        result = trials.run(weights) if weights else None
        return math.inf if result is None else cost_of(result)

    with bar(rounds, progress) as advance:
        best = searched(cost, np.append(np.zeros(len(TUNED)), DEFAULT_WEIGHTS.bank), rounds, advance)
    weights = weights_at(best) or DEFAULT_WEIGHTS
    judge = DesignTrials(geared, y, u, scenes, DESIGN_JUDGES * ships, seed + 1, noise)
    return RegulatorDesign(geared, float(y), float(u), weights, _judged(judge, weights))


def with_gear(model: Model, gear: SteeringGear) -> Model:
    """Return the model with another steering gear."""
    return replace(model, configuration=replace(model.configuration, steering=gear))


def weights_at(point: np.ndarray) -> RegulatorWeights | None:
    """Return the weights of a point of the search; None if they are invalid."""
    tuned: dict[str, Any] = {n: getattr(DEFAULT_WEIGHTS, n) * math.exp(p) for n, p in zip(TUNED, point, strict=False)}
    bank = float(point[-1])
    return RegulatorWeights(**tuned, bank=bank) if 0.0 <= bank <= 1.0 else None


def cost_of(result: TrialResult) -> float:
    late = np.minimum(result.off, 3.0)
    travel = np.minimum(result.travel, 2 * FULL_TRAVEL * TRIAL_LENGTHS)
    return float(
        result.lost.mean() + OFF_SHARE * late.mean() + TRAVEL_SHARE * travel.mean() / (FULL_TRAVEL * TRIAL_LENGTHS)
    )


def _judged(trials: DesignTrials, weights: RegulatorWeights) -> dict[str, dict[str, float]]:
    tuned, default = trials.run(weights), trials.run(DEFAULT_WEIGHTS)
    assert tuned is not None
    assert default is not None
    return {
        name: {
            "lost": float(tuned.lost[row].mean()), "usual": float(default.lost[row].mean()),
            "travel": float(np.median(tuned.travel[row])), "usual_travel": float(np.median(default.travel[row])),
        }
        for row, name in enumerate(SCENES)
    }  # fmt: skip


def searched(
    cost: Callable[[np.ndarray], float], start: np.ndarray, rounds: int, advance: Callable[[int], Any]
) -> np.ndarray:
    """Return the best point of a simplex search that stays away from infinite costs."""
    from scipy.optimize import minimize

    evaluations = count(1)

    def counted(point: np.ndarray) -> float:
        advance(int(next(evaluations) % DESIGNS_A_ROUND == 0))
        return cost(point)

    # The last number, the bank's share, moves down: it may be 1 already.
    corners = start + np.vstack([np.zeros(len(start)), np.diag([*[DESIGN_STEP] * (len(start) - 1), -DESIGN_STEP])])
    options: Any = {"maxfev": DESIGNS_A_ROUND * rounds, "initial_simplex": corners, "xatol": 1e-4, "fatol": 0.0}
    return np.asarray(minimize(counted, start, method="Nelder-Mead", options=options).x)
