"""Steady courses with the best estimate of the coefficients, as a pilot assumes without further information."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import xarray as xr

from narrows.control.regulator import IN_VAIN
from narrows.control.steady_course import solved, with_propulsion
from narrows.errors import InputError
from narrows.safety.request import STRAIGHT, Bend
from narrows.simulation.grid import grid_of
from narrows.simulation.ship import SimulatedShip

Columns = dict[str, np.ndarray]


@dataclass(frozen=True)
class BestEstimateCourses:
    """Courses at offsets and speeds, and on the middle."""

    ship: SimulatedShip  # Ship with the best estimate of the coefficients
    offsets: np.ndarray  # (offsets,) Offsets to starboard of the middle [m]
    speeds: np.ndarray  # (speeds,) Speeds through the water [m/s]
    heave: np.ndarray  # (speeds,) Midship sinkage [m]
    bend: Bend = STRAIGHT
    wind: tuple[float, float] = (0.0, 0.0)  # Sway force [N] and yaw moment [N m]

    @cached_property
    def places(self) -> np.ndarray:
        """The offsets, with the middle as the last [m]."""
        return np.append(self.offsets, 0.0)

    @cached_property
    def values(self) -> Columns:
        """Numbers of the ship, and those that depend on speed, one column each: places by speeds, row by row."""
        offset = xr.DataArray(self.places, dims="place")
        asked = {"y": offset, "u": self.speeds, "heave": xr.DataArray(self.heave, dims="u")}
        grid = grid_of(self.ship.model, with_propulsion(self.ship.model, asked), 0, 0)
        shape = (len(self.places), len(self.speeds))
        wide = {
            name: value.transpose(*(d for d in ("place", "u") if d in value.dims))
            for name, value in grid.values.items()
        }
        return {name: _column(value, shape) for name, value in wide.items()}

    @cached_property
    def course(self) -> Columns:
        """y [m], u, v [m/s], rudder [rad], and other moving quantities; NaN if no rudder angle holds the ship."""
        values = {**self.values, **self.bend.values(self.values["y"]), "Y": self.wind[0], "N": self.wind[1]}
        v, rudder = solved(self.ship, values, self.values["y"].size, 1)
        within = np.abs(rudder) <= self.ship.model.configuration.gear.limit
        course = {name: self.values[name] for name in ("y", "u")}
        course |= {a.name: self.values[a.name] for a in self.ship.actuators if a.name in self.values}
        return {**course, "v": np.where(within, v, np.nan), "rudder": np.where(within, rudder, np.nan)}

    def held(self) -> Columns:
        """Return rudder, psi [rad] and v [m/s] at offsets and speeds, (offsets, speeds)."""
        course = np.stack(
            [self.course["rudder"], -np.arctan(self.course["v"] / self.course["u"]), self.course["v"]], axis=-1
        )
        return dict(zip(("rudder", "psi", "v"), np.moveaxis(self.filled(course), -1, 0), strict=True))

    def filled(self, columns: np.ndarray) -> np.ndarray:
        """Return columns at offsets and speeds, (offsets, speeds, n); NaN is replaced by the nearest place's value."""
        # columns (places x speeds, n)
        table = columns.reshape(len(self.places), len(self.speeds), -1)
        known = np.isfinite(table).all(axis=-1)
        held = np.flatnonzero(known.any(axis=0))
        if not held.size or (len(held) < len(self.speeds) and not any(self.wind)):
            raise InputError(IN_VAIN)
        # In a wind that leaves no course at a speed, that of the nearest speed with one stands in.
        instead = held[np.abs(self.speeds[:, None] - self.speeds[held]).argmin(axis=1)]
        table, known = table[:, instead], known[:, instead]
        far = np.abs(self.places[:, None] - self.offsets[None, :])[:, :, None]
        nearest = np.where(known[:, None, :], far, np.inf).argmin(axis=0)
        return np.asarray(table[nearest, np.arange(len(self.speeds))])

    def on_the_centreline(self) -> Iterator[tuple[float, dict[str, float]]]:
        """Yield each speed [m/s] with the dependent quantities: heave [m], revolutions [1/s]."""
        given = [name for name in ("heave", "revolutions") if name in self.values]
        for index, speed in enumerate(self.speeds):
            yield float(speed), {name: float(self.values[name][index]) for name in given}


def _column(value: xr.DataArray, shape: tuple[int, int]) -> np.ndarray:
    wide = value.to_numpy()
    if "place" in value.dims and "u" not in value.dims:
        wide = wide[:, None]
    return np.ascontiguousarray(np.broadcast_to(wide, shape)).ravel()
