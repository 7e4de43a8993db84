"""The estimated state of a ship at a moment: values, uncertainty, and a verdict on the readings."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.estimation.states import StateNames, described
from narrows.estimation.unscented import Gaussian
from narrows.results import BaseSummary, Tabulated
from narrows.results.base_results import with_error

if TYPE_CHECKING:
    import pandas as pd
    import xarray


@dataclass(frozen=True, repr=False, eq=False)
class Estimate(BaseSummary):
    """The state of a ship at a moment."""

    t: float  # Time [s]
    states: StateNames
    # Mean and root of the covariance, with corrections of the coefficients after the states; none before the start
    joint: Gaussian | None
    ready: bool  # True while it follows the readings: false before the start, and from a reset to the next start
    nis: dict[str, float]  # Normalised innovation squared of each reading [1]
    refused: tuple[str, ...] = ()  # Sensors with a reading too far from the prediction
    suspects: tuple[str, ...] = ()  # Sensors whose innovations are biased, or that are left out
    notes: tuple[str, ...] = ()  # Notes, one sentence each
    faults: tuple[str, ...] = ()  # Sensors, ``rudder`` or ``model`` that contradict the others and are left out

    @property
    def normal(self) -> Gaussian | None:
        """Mean and root of the covariance of the states; none before the start."""
        size = len(self.states)
        return Gaussian(self.joint.mean[:size], self.joint.root[:size]) if self.joint else None

    @property
    def values(self) -> dict[str, float]:
        """The state by name, SI units; empty before the start. The heading lies within half a turn."""
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
        """The covariance, (states, states); empty before the start."""
        return np.zeros((0, 0)) if self.normal is None else self.normal.covariance

    def __getitem__(self, name: str) -> float:
        """A state by its name."""
        return self.values[name]

    def summary(self) -> str:
        """Describe place, heading and speed, their uncertainty, and the verdict on the readings."""
        if self.normal is None:
            return f"t = {self.t:g} s: nothing to start from yet."
        values, std = self.values, self.std
        shown = {name: with_error(values[name], 1.96 * std[name]) for name in ("x", "y", "psi", "u")}
        parts = [f"{name} = {value} {described(name)[0]}" for name, value in shown.items()]
        return "\n".join([f"t = {self.t:g} s: {', '.join(parts)} (95 %).", *self.notes])


@dataclass(frozen=True, repr=False, eq=False)
class EstimatedTrack(Tabulated):
    """States of a ship over time."""

    t: np.ndarray  # (times,) Time [s]
    mean: np.ndarray  # (times, states) Estimates
    covariance: np.ndarray  # (times, states, states) Covariances of their errors
    states: tuple[str, ...]
    ready: np.ndarray  # (times,) True if the estimate followed the readings
    refused: dict[str, np.ndarray]  # (times,) True if a reading of the sensor was refused
    suspected: dict[str, np.ndarray]  # (times,) True if the innovations of the sensor were biased
    smoothed: bool  # True if later readings are used too
    notes: tuple[str, ...]  # Notes on validity

    @property
    def std(self) -> np.ndarray:
        """Standard deviations, (times, states)."""
        return np.asarray(np.sqrt(np.maximum(np.diagonal(self.covariance, axis1=1, axis2=2), 0.0)))

    def __getitem__(self, name: str) -> np.ndarray:
        """The estimates of a state."""
        return np.asarray(self.mean[:, self.states.index(name)])

    def summary(self) -> str:
        """Describe its duration, the uncertainty of the place, and which sensors were refused or suspected."""
        std = dict(zip(self.states, np.median(self.std, axis=0).tolist(), strict=True))
        by = "all readings" if self.smoothed else "the readings until then"
        lines = [
            f"{len(self.t)} times from {self.t[0]:g} to {self.t[-1]:g} s, each by {by}; the offset is known to "
            f"{1.96 * std['y']:.2g} m (95 %), the heading to {np.degrees(1.96 * std['psi']):.2g} deg."
        ]
        for what, flags in (("refused", self.refused), ("suspected of drifting", self.suspected)):
            counts = {name: int(flag.sum()) for name, flag in flags.items() if flag.any()}
            lines += [f"{name} was {what} at {count} of them." for name, count in counts.items()]
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """Return counts and the median standard deviations by name."""
        std = dict(zip(self.states, np.median(self.std, axis=0).tolist(), strict=True))
        counts = {"times": len(self.t), "ready": int(self.ready.sum()), "smoothed": self.smoothed}
        flags = {"refused": self.refused, "suspected": self.suspected}
        flagged = {what: {name: int(flag.sum()) for name, flag in by.items()} for what, by in flags.items()}
        return {"median_std": std, **counts, **flagged, "summary": self.summary(), "notes": list(self.notes)}

    def to_dataframe(self) -> "pd.DataFrame":
        """Return one row per time: states and their standard deviations."""
        frame: pd.DataFrame = self.dataset().drop_dims("other").drop_vars("state").to_dataframe()
        return frame

    def dataset(self) -> "xarray.Dataset":
        """Return states, standard deviations, the covariance and the verdict on the sensors, with units."""
        import xarray

        std = self.std
        data: dict[str, Any] = {}
        for place, name in enumerate(self.states):
            unit, meaning = described(name)
            data[name] = ("t", self.mean[:, place], {"units": unit, "long_name": meaning})
            data[f"{name}_std"] = ("t", std[:, place], {"units": unit, "long_name": f"standard deviation of {meaning}"})
        data["ready"] = ("t", self.ready.astype(np.int8), {"units": "1", "long_name": "follows the readings"})
        for what, flags in (("refused", self.refused), ("suspected", self.suspected)):
            data |= {f"{name}_{what}": ("t", flag.astype(np.int8), {"units": "1"}) for name, flag in flags.items()}
        data["covariance"] = (("t", "state", "other"), self.covariance, {"units": "product of those of the states"})
        coordinates: dict[str, Any] = {name: list(self.states) for name in ("state", "other")}
        coordinates["t"] = "t", self.t, {"units": "s", "long_name": "time"}
        return xarray.Dataset(data, coordinates, {"summary": self.summary(), "notes": "\n".join(self.notes)})
