"""What is known of a ship at a moment: values, how sure they are, and what was thought of the readings."""

import math
from dataclasses import dataclass

import numpy as np

from narrows.estimation.states import STATES, StateNames
from narrows.estimation.unscented import Normal
from narrows.results import Described


@dataclass(frozen=True, repr=False, eq=False)
class Estimate(Described):
    """The state of a ship at a moment.

    Parameters
    ----------
    t : float [s]
        When.
    states : StateNames
        What is estimated.
    normal : Normal, optional
        Mean and root of the covariance; none before there was anything to start from.
    ready : bool
        Whether it follows the readings: not before the start, nor from a reset to the next start.
    nis : dict of str to float
        Normalised innovation squared of each reading that came [1].
    refused : tuple of str
        Sensors whose reading was too far from what was expected.
    suspects : tuple of str
        Sensors whose readings lean to one side.
    notes : tuple of str
        What to know of it, each a sentence.
    joint : Normal, optional
        The state and what is estimated beside it, the directions of the coefficients' covariance, as one.
    """

    t: float
    states: StateNames
    normal: Normal | None
    ready: bool
    nis: dict[str, float]
    refused: tuple[str, ...] = ()
    suspects: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    joint: Normal | None = None

    @property
    def values(self) -> dict[str, float]:
        """The state by name, SI units; empty where there is none yet. The heading lies within half a turn."""
        if self.normal is None:
            return {}
        values = dict(zip(self.states.names, self.normal.mean.tolist(), strict=True))
        return {**values, "psi": math.remainder(values["psi"], 2.0 * math.pi)}

    @property
    def std(self) -> dict[str, float]:
        """Standard deviations by name."""
        if self.normal is None:
            return {}
        sizes = np.sqrt((self.normal.root**2).sum(axis=1))
        return dict(zip(self.states.names, sizes.tolist(), strict=True))

    @property
    def covariance(self) -> np.ndarray:
        """The covariance, (states, states); of no size where there is no state yet."""
        return np.zeros((0, 0)) if self.normal is None else self.normal.covariance

    def __getitem__(self, name: str) -> float:
        """A state by its name."""
        return self.values[name]

    def summary(self) -> str:
        """Say place, heading and speed, how sure they are, and what was thought of the readings."""
        if self.normal is None:
            return f"t = {self.t:g} s: nothing to start from yet."
        values, std = self.values, self.std
        parts = [
            f"{name} = {values[name]:.4g} +- {1.96 * std[name]:.2g} {STATES[name][0]}"
            for name in ("x", "y", "psi", "u")
        ]
        told = [f"t = {self.t:g} s: {', '.join(parts)} (95 %)."]
        return "\n".join([*told, *self.notes])
