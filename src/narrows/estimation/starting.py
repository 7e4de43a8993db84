"""From the first readings to a state: place, heading and speed are read, the rest is believed."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from narrows.estimation.process_noise import Prior
from narrows.estimation.sensor import Sensor
from narrows.estimation.states import Columns, StateNames
from narrows.estimation.unscented import Normal

# What there must be to start from, and what it is called.
NEEDED = {"x": "a place", "y": "a place", "psi": "a heading", "u": "a speed through the water"}
# Of finding midship from an antenna.
ROUNDS = 6
# A difference of heading [rad] for a derivative.
SMALL_TURN = 1e-4


@dataclass
class Start:
    """Readings as they come, until there are enough to start from."""

    states: StateNames  # What is estimated
    sensors: Mapping[str, Sensor]  # By the names of their readings
    prior: Prior  # What is believed without readings
    biases: Mapping[str, float]  # Standard deviations of the biases, by the names of states
    current: float = 0.0  # Along the waterway, as it is known [m/s]
    readings: dict[str, Sequence[float]] = field(default_factory=dict)  # What came in so far

    def told(self) -> dict[str, tuple[float, float]]:
        """Return what the readings tell, with standard deviations: of two that tell the same, the better."""
        told: dict[str, tuple[float, float]] = {}
        for name, reading in self.readings.items():
            for state, (value, size) in self.sensors[name].start(reading).items():
                if state not in told or size < told[state][1]:
                    told[state] = (float(value), size)
        return told

    @property
    def lacking(self) -> str:
        """What is not known yet, in words; empty where there is enough."""
        told = self.told()
        return " and ".join(dict.fromkeys(what for state, what in NEEDED.items() if state not in told))

    def normal(self, considered: int, bend: float) -> Normal:
        """Return the state by the readings and what is believed."""
        # bend [1/m]
        told, prior = self.told(), self.prior
        believed = {
            "v": (0.0, prior.sway), "r": (0.0, prior.yaw_rate), "bank": (1.0, prior.bank),
            "current": (self.current, prior.current), "current_across": (0.0, prior.current_across),
            **{name: (0.0, size) for name, size in self.biases.items()}, **told,
        }  # fmt: skip
        mean = self.states.vector({name: value for name, (value, _) in believed.items()})
        root = np.diag([believed[name][1] for name in self.states.names])
        places = self.states.places
        if "heading_bias" in places:  # What the compass indicates is the heading and its bias together.
            root[places["psi"], places["heading_bias"]] = -root[places["heading_bias"], places["heading_bias"]]
        return Normal(self._at_midship(mean, root, bend), np.hstack([np.zeros((len(mean), considered)), root]))

    def _at_midship(self, mean: np.ndarray, root: np.ndarray, bend: float) -> np.ndarray:
        """Bring the place of an antenna to midship, in the mean and, as far as the heading is unsure, in the root."""
        name = next(name for name, reading in self.readings.items() if "x" in self.sensors[name].start(reading))
        sensor, told = self.sensors[name], np.array(self.readings[name], float)

        def measured(state: np.ndarray) -> np.ndarray:
            found = sensor.measured(Columns(state[None], self.states, bend))
            return np.array([float(np.ravel(number)[0]) for number in found])

        for _ in range(ROUNDS):
            mean = mean.copy()
            mean[:2] += told - measured(mean)
        turned = mean.copy()
        turned[2] += SMALL_TURN
        root[:2] -= np.outer((measured(turned) - measured(mean)) / SMALL_TURN, root[2])
        return mean
