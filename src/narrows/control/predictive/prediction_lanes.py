"""What a ship will do, by the package's own kernel: every interval of a plan a lane, all in one call."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.codegen.free_motion import INPUTS
from narrows.simulation.kernel_run import PUSH_END, KernelRun
from narrows.simulation.ship import SimulatedShip
from narrows.simulation.steering import PARAMETER, steering_of

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway

# Of Runge and Kutta's method, an interval.
STEPS = 2
# Where a waterway ends; for a plan it is far off [m]: beyond its end it goes on as it ends.
LAST, FAR = "x_last", 1e12
# Of a waterway [m], where a lane begins at the earliest: at the very start it would be at its end.
AFTER_THE_START = 1e-3
TURNING = "turning"


class RudderTurning:
    """A law that turns the rudder at a rate, one of its own in every lane."""

    def __init__(self, turning: np.ndarray) -> None:
        self.turning = turning

    def parameters(self) -> Mapping[str, Any]:
        """Return the rates."""
        return {TURNING: self.turning}

    def memory(self, start: Mapping[str, Any]) -> Mapping[str, Any]:
        """Return nothing."""
        return {}

    def orders(self, at: Any) -> tuple[Mapping[str, Any], Mapping[str, Any]]:
        """Return the angle at the end of the step."""
        return {"rudder": at.rudder + at.turning * at.dt}, {}


class PredictionLanes:
    """Lanes of one ship, laid out once: each sails from a state of its own for one interval."""

    def __init__(self, ship: SimulatedShip, waterway: "Waterway | None", lanes: int, **positions: float) -> None:
        steering = steering_of(RudderTurning(np.zeros(lanes)), ship.actuators)
        run = KernelRun(ship, 1.0, 1.0, steering=steering, waterway=waterway)
        still = dict.fromkeys(("x", "y", "psi", "v", "r", "X", "rudder"), 0.0)
        pushed = {"Y": np.zeros(lanes), "N": np.zeros(lanes), PUSH_END: np.inf}
        prepared = run.prepared({**still, **pushed, "u": 1.0, **positions}, lanes, workers=1)
        kept, inputs = prepared.kernel.KEPT_NAMES, prepared.kernel.VESSEL_INPUTS
        if LAST in prepared.kernel.SHARED:
            prepared.shared[prepared.kernel.SHARED.index(LAST)] = FAR
        self._prepared = prepared
        self._places = {name: kept.index(name) for name in ("x", "y", "cos_psi", "sin_psi", "u", "v", "r", "rudder")}
        self._turning = inputs.index(PARAMETER(TURNING))
        self._pushes = [inputs.index(INPUTS[name]) for name in ("Y", "N")]

    def __call__(
        self, x: np.ndarray, states: np.ndarray, speed: float, rates: np.ndarray, push: np.ndarray, time: float
    ) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
        """Return where lanes are after a time: x (lanes,) [m] and y, psi, v, r, rudder (lanes, 5)."""
        # x (lanes,) [m]; states (lanes, 5); speed [m/s]; rates (lanes,) [rad/s]; push (lanes, 2) [N, N m]; time [s]
        # A lane that meets a bank stays there.
        run, at = self._prepared, self._places
        start, end = run.start, run.end
        psi = states[:, 1]
        begin = np.maximum(x, AFTER_THE_START)
        start[:, at["x"]], start[:, at["y"]], start[:, at["u"]] = begin, states[:, 0], speed
        start[:, at["cos_psi"]], start[:, at["sin_psi"]] = np.cos(psi), np.sin(psi)
        start[:, at["v"]], start[:, at["r"]], start[:, at["rudder"]] = states[:, 2], states[:, 3], states[:, 4]
        run.times[:] = time / STEPS, STEPS, 0.0
        run.vessel_inputs[:, self._turning] = rates
        run.vessel_inputs[:, self._pushes] = push
        run()
        after = np.empty_like(states)
        after[:, 0], after[:, 1] = end[:, at["y"]], np.arctan2(end[:, at["sin_psi"]], end[:, at["cos_psi"]])
        after[:, 2], after[:, 3], after[:, 4] = end[:, at["v"]], end[:, at["r"]], end[:, at["rudder"]]
        return x + (end[:, at["x"]] - begin), after
