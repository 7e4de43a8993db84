"""The start of an estimate, from some readings of each sensor."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from narrows.errors import InputError
from narrows.estimation.sensors import error_states
from narrows.estimation.settings import START_READINGS
from narrows.estimation.ship_filter import ShipFilter
from narrows.estimation.states import Columns
from narrows.estimation.unscented import Gaussian

# States needed for a start, in words; the other states begin at their priors.
NEEDED = {"x": "a place", "y": "a place", "psi": "a heading", "u": "a speed through the water"}


@dataclass
class Start:
    """The latest readings of each sensor, collected for a start: their median, not the first."""

    filter: ShipFilter
    readings: dict[str, list[tuple[float, Sequence[float]]]] = field(default_factory=dict)  # With their times [s]

    def add(self, t: float, readings: Mapping[str, Sequence[float]]) -> None:
        for name, reading in readings.items():
            self.readings[name] = [*self.readings.get(name, ())[1 - START_READINGS :], (t, reading)]

    def values(self) -> dict[str, tuple[float, dict[str, float]]]:
        """Return states, each with the entries of its row of the root; of two sensors of a state, the better."""
        found: dict[str, tuple[float, dict[str, float]]] = {}
        for name, rows in self.readings.items():
            if len(rows) < START_READINGS:
                continue
            sensor, reading = self.filter.sensors[name], rows[-1][1]
            for state, (last, std) in sensor.start(reading).items():
                values = [sensor.start(one)[state][0] for _, one in rows]
                if state == "psi":
                    values = [last + math.remainder(value - last, 2.0 * math.pi) for value in values]
                entries = {state: std}
                for error, (place, size, _) in error_states(sensor, name in self.filter.faults).items():
                    moved = [number + (component == place) for component, number in enumerate(reading)]
                    entries[error] = -size * (sensor.start(moved)[state][0] - last)
                if state not in found or math.hypot(*entries.values()) < math.hypot(*found[state][1].values()):
                    found[state] = float(np.median(values)), entries
        return found

    @property
    def missing(self) -> str:
        """Return what is missing, in words; empty if there are enough readings."""
        known = self.values()
        return " and ".join(dict.fromkeys(what for state, what in NEEDED.items() if state not in known))

    def refusal(self) -> InputError:
        what = f"an estimate starts from {START_READINGS} readings of each"
        return InputError(f"these records lack {self.missing}; {what}")

    def state(self, t: float) -> Gaussian:
        """Return the state at a time from the readings and the priors."""
        filter, known = self.filter, self.values()
        names, places = filter.states.names, filter.states.places
        current = float(filter.waterway.current_at(known["x"][0])) if filter.waterway else 0.0
        mean = filter.states.vector({"current": current, **{name: value for name, (value, _) in known.items()}})
        size, more = len(names), filter.estimated
        full = np.diag([filter.spreads.get(name, 0.0) for name in names] + [1.0] * more)
        for name, (_, entries) in known.items():
            for other, entry in entries.items():
                full[places[name], places[other]] = entry
        return Gaussian(np.concatenate([self._at_midship(t, mean, full[:size], current), np.zeros(more)]), full)

    def _at_midship(self, t: float, mean: np.ndarray, root: np.ndarray, current: float) -> np.ndarray:
        """Convert antenna positions to one time and to midship, in the root too, since the heading is uncertain."""
        filter = self.filter
        name = next(name for name, rows in self.readings.items() if "x" in filter.sensors[name].start(rows[-1][1]))
        sensor, u, psi = filter.sensors[name], mean[3], mean[2]
        way = np.array([u * math.cos(psi) + current, u * math.sin(psi)])
        place = np.median([np.array(reading) + (t - then) * way for then, reading in self.readings[name]], axis=0)
        bend = filter.lanes.bend(float(place[0]))

        def measured(state: np.ndarray) -> np.ndarray:
            found = sensor.measured(Columns(state[None], filter.states, bend))
            return np.array([float(np.ravel(number)[0]) for number in found])

        for _ in range(6):  # In a bend each round leaves a small share of the error
            mean = mean.copy()
            mean[:2] += place - measured(mean)
        small = 1e-4  # [rad]
        turned = mean.copy()
        turned[2] += small
        root[:2] -= np.outer((measured(turned) - measured(mean)) / small, root[2])
        return mean
