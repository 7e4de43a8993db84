"""Many voyages of one model at once: numbers and columns by name in, columns of ends out."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from narrows.compile.kernel import Precision
from narrows.compile.trace import INPUTS
from narrows.simulation.grid import INPUTS as PUSHED
from narrows.simulation.grid import START
from narrows.simulation.ship import SimulatedShip, helm

STATE_AT_END = ("y", "psi", "u", "v", "r")
KEPT: dict[str, type] = {
    "outcome": np.int8, "side": np.int8, "time": np.float64, "distance": np.float64,
    **{f"{name}_end": np.float64 for name in STATE_AT_END},
}  # fmt: skip
"""What is kept of each voyage, and as what."""

Result = dict[str, np.ndarray]


@dataclass(frozen=True)
class Fleet:
    """How to run voyages.

    Parameters
    ----------
    ship : SimulatedShip
        The model and the choices of simulation.
    duration : float [s]
        Longest time.
    dt : float [s]
        Step.
    precision : str
        ``float64`` or ``float32``.
    """

    ship: SimulatedShip
    duration: float
    dt: float
    precision: Precision = "float64"

    def run(self, values: Mapping[str, Any], vessels: int, workers: int | None = None) -> Result:
        """Run voyages.

        Parameters
        ----------
        values : mapping of str to float or array (vessels,)
            Start, inputs, particulars, coefficients.
        vessels : int
            How many.
        workers : int, optional
            Threads.
        """
        start = {name: values[name] for name in START}
        start["y"] = np.broadcast_to(np.asarray(values["y"], float), vessels)
        rest = {
            name: value
            for name, value in values.items()
            if name not in START and name not in PUSHED and name != "rudder"
        }
        # Forces from outside cost a little in each step, so they go in only where there are any.
        pushed = {name: values[own] for own, name in INPUTS.items() if np.any(values[own])}
        given = {**self.ship.values(), **rest, **helm(values["rudder"]), **pushed}
        ended = self.ship.program.fleet(
            given, dt=self.dt, duration=self.duration, precision=self.precision, workers=workers, **start
        )
        ends = {f"{name}_end": getattr(ended, name) for name in STATE_AT_END}
        distance = ended.x - start["x"]
        return {"outcome": ended.outcome, "side": ended.side, "time": ended.time, "distance": distance, **ends}

    @property
    def text(self) -> str:
        """What tells this fleet from others, beside the values that vary."""
        options = (self.duration, self.dt, self.precision, self.ship.surge, self.ship.coriolis, self.ship.contact)
        return f"{self.ship.program.record.text} {options!r} {sorted(self.ship.values().items(), key=str)!r}"
