"""A record as the checks take it: with the ship that it is of, and its motion at even times."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from narrows.logbook.checking.even_motion import EvenMotion
from narrows.logbook.checking.finding import Finding
from narrows.logbook.ship_record import ShipRecord
from narrows.model.model import Model
from narrows.waterway import Waterway


class Examined(NamedTuple):
    """A record that is looked at."""

    record: ShipRecord  # As it was measured
    motion: EvenMotion  # The same at even times
    model: Model  # Of the ship
    waterway: Waterway | None  # That x and y are told along

    @property
    def length(self) -> float:
        """Of the ship [m]."""
        return self.model.configuration.ship.length

    @property
    def speed(self) -> float:
        """Usual one [m/s]."""
        return self.length / self.motion.pace

    def finding(
        self, check: str, sentence: str, remedy: str, evidence: Mapping[str, float], wrong: bool = True
    ) -> Finding:
        """Return a finding of this record."""
        return Finding(
            check, self.record.name, sentence, remedy, {name: float(n) for name, n in evidence.items()}, wrong
        )

    @property
    def turning(self) -> np.ndarray | None:
        """Yaw rate at even times [rad/s], by the sensor or else by the heading; None where there is neither."""
        if "r" in self.motion:
            return self.motion["r"]
        return np.gradient(self.motion.heading, self.motion.dt) if "psi" in self.motion else None
