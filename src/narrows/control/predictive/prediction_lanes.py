"""Predict the ship over the horizon by the kernel: each interval of a plan is a lane (multiple shooting)."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.codegen.free_motion import INPUTS
from narrows.control.settings import STEPS
from narrows.simulation.kernel_run import PUSH_END, KernelRun
from narrows.simulation.ship import SimulatedShip
from narrows.simulation.steering import PARAMETER, steering_of

if TYPE_CHECKING:
    from narrows.waterway.waterway import Waterway


class RudderTurning:
    """A law that turns the rudder at a rate, a different one in every lane."""

    def __init__(self, turning: np.ndarray) -> None:
        self.turning = turning

    def parameters(self) -> Mapping[str, Any]:
        return {"turning": self.turning}

    def memory(self, start: Mapping[str, Any]) -> Mapping[str, Any]:
        return {}

    def orders(self, at: Any) -> tuple[Mapping[str, Any], Mapping[str, Any]]:
        return {"rudder": at.rudder + at.turning * at.dt}, {}


class PredictionLanes:
    """Lanes of one ship, allocated once: each starts from its own state and lasts one interval."""

    def __init__(self, ship: SimulatedShip, waterway: "Waterway | None", lanes: int, **positions: float) -> None:
        steering = steering_of(RudderTurning(np.zeros(lanes)), ship.placed_actuators)
        run = KernelRun(ship, 1.0, 1.0, steering=steering, waterway=waterway)
        still = dict.fromkeys(("x", "y", "psi", "v", "r", "X", "rudder"), 0.0)
        pushed = {"Y": np.zeros(lanes), "N": np.zeros(lanes), PUSH_END: np.inf}
        prepared = run.prepared({**still, **pushed, "u": 1.0, **positions}, lanes, workers=1)
        kept, inputs = prepared.kernel.KEPT_NAMES, prepared.kernel.VESSEL_INPUTS
        if "x_last" in prepared.kernel.SHARED:  # For a plan the waterway continues beyond its end with the last section
            prepared.shared[prepared.kernel.SHARED.index("x_last")] = 1e12
        self._prepared = prepared
        self._places = {name: kept.index(name) for name in ("x", "y", "cos_psi", "sin_psi", "u", "v", "r", "rudder")}
        self._turning = inputs.index(PARAMETER("turning"))
        self._pushes = [inputs.index(INPUTS[name]) for name in ("Y", "N")]

    def __call__(
        self, x: np.ndarray, states: np.ndarray, speed: float, rates: np.ndarray, push: np.ndarray, time: float
    ) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
        """Return the lanes' states after a time: x (lanes,) [m] and y, psi, v, r, rudder (lanes, 5)."""
        # rates (lanes,) [rad/s]; push (lanes, 2) [N, N m]. A lane that meets a bank stays there.
        run, at = self._prepared, self._places
        start, end = run.start, run.end
        psi = states[:, 1]
        begin = np.maximum(x, 1e-3)  # A lane at the very start of a waterway would be at its end
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
