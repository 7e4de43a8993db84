"""Helms that hold ships in trials, by name: each made for the mean coefficients, none told those of the ship."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from narrows.control.linearization import linearize
from narrows.control.regulator import LEAD, UNWINDING, held_gains
from narrows.control.regulator_law import FELT, TURNED, HeldLine, Regulator
from narrows.control.track_pilot import track_gains
from narrows.errors import check_choice
from narrows.quantities.arithmetic import choice, maximum
from narrows.simulation.controllers import Autopilot, ControlLaw, Named
from narrows.simulation.grid import Grid
from narrows.simulation.ship import SimulatedShip

REGULATOR, TRACK = "regulator", "track"
IN_WORDS = {
    REGULATOR: "the regulator, made for the mean coefficients, its integral settled before the ship is thrown off",
    TRACK: "the track pilot without an integral, told the steady course that each ship asks for",
}
"""What a helm is, and what it knows."""


@dataclass(frozen=True)
class TrialHelm:
    """A helm as trials ask for it.

    Parameters
    ----------
    law : ControlLaw
        What gives the orders.
    numbers : mapping of str to DataArray
        Of the law, over offsets and speeds.
    line : mapping of str to str
        What the law calls ``y`` [m], ``rudder``, ``psi`` [rad] and ``v`` [m/s] of the course that it holds.
    """

    law: ControlLaw
    numbers: Mapping[str, xr.DataArray]
    line: Mapping[str, str]


@dataclass(frozen=True)
class Watched:
    """A control law that remembers how far off a line the ship was from a time on (ours).

    Parameters
    ----------
    law : ControlLaw
        What gives the orders.
    y : number [m]
        The line.
    late_from : number [s]
        From when.
    """

    law: ControlLaw
    y: Any = 0.0
    late_from: Any = 0.0

    def parameters(self) -> Mapping[str, Any]:
        """Return the numbers of the law, the line, and from when it counts."""
        return {**self.law.parameters(), "watched_y": self.y, "late_from": self.late_from}

    def memory(self, start: Named) -> Named:
        """Return the memory of the law, and how far off the ship was so far.

        Parameters
        ----------
        start : mapping of str to number
            The state at the start.
        """
        return {**self.law.memory(start), "farthest": 0.0}

    def orders(self, at: Any) -> tuple[Named, Named]:
        """Return the order, and how far off the ship was.

        Parameters
        ----------
        at : object
            Quantities by name.
        """
        orders, memory = self.law.orders(at)
        counted = choice(at.t + at.dt / 2 - at.late_from, abs(at.y - at.watched_y), 0.0)
        return orders, {**memory, "farthest": maximum(at.farthest, counted)}


def trial_helm(name: str, ship: SimulatedShip, grid: Grid, y: np.ndarray, u: np.ndarray) -> TrialHelm:
    """Return a helm for trials at offsets and speeds (ours).

    Parameters
    ----------
    name : str
        ``regulator``, or ``track`` for the track pilot without an integral.
    ship : SimulatedShip
        Its mean coefficients.
    grid : Grid
        Of the trials: heave and revolutions at each speed.
    y : array (offsets,) [m]
        To hold.
    u : array (speeds,) [m/s]
        Held.

    Raises
    ------
    InputError
        Where there is no such helm, or none of it holds the ship.
    """
    check_choice("controller", name, MADE)
    felt = [each for each in ("heave", "revolutions") if each in grid.values and grid.values[each].ndim]
    columns = {each: np.broadcast_to(grid.values[each].to_numpy(), len(u)) for each in felt}
    rows = [{each: float(column[index]) for each, column in columns.items()} for index in range(len(u))]
    return MADE[name](ship, y, u, rows)


def _track(ship: SimulatedShip, y: np.ndarray, u: np.ndarray, rows: list[dict[str, float]]) -> TrialHelm:
    gains = np.array([track_gains(ship, float(speed), **row) for speed, row in zip(u, rows, strict=True)])
    numbers = {f"by_{name}": xr.DataArray(gains[:, i], dims="u") for i, name in enumerate(("y", "psi", "v", "r"))}
    line = {name: f"held_{name}" for name in ("y", "rudder", "psi", "v")}
    return TrialHelm(Autopilot(0.0, (0.0, 0.0, 0.0, 0.0)), numbers, line)


def _regulator(ship: SimulatedShip, y: np.ndarray, u: np.ndarray, rows: list[dict[str, float]]) -> TrialHelm:
    """Its integral has found the steady course of the ship that it steers before the ship is thrown off."""
    gains = np.stack([_at_speed(ship, y, float(speed), row) for speed, row in zip(u, rows, strict=True)], axis=1)
    numbers = {f"by_{name}_0": xr.DataArray(gains[..., i], dims=("y", "u")) for i, name in enumerate(FELT)}
    time = ship.model.configuration.ship.length / np.asarray(u)
    numbers |= {"made_for": xr.DataArray(u, dims="u"), "unwinding": xr.DataArray(UNWINDING * time, dims="u")}
    zero = xr.DataArray(np.zeros(len(u)), dims="u")
    numbers |= {"lead": xr.DataArray(LEAD * time, dims="u"), **{f"turn_{name}_0": zero for name in TURNED}}
    line = {name: f"held_{name}_0" for name in ("y", "rudder", "psi", "v")}
    return TrialHelm(Regulator((HeldLine(0.0, (1.0, 1.0, 1.0, 1.0, 1.0, 1.0)),), 1.0, 0.0, 1.0), numbers, line)


def _at_speed(ship: SimulatedShip, y: np.ndarray, u: float, row: dict[str, float]) -> np.ndarray:
    """Gains at offsets, (offsets, 6): of the middle where the mean ship has no steady course."""
    model, about = ship.model, partial(linearize, ship.model, u=u, waterway=None, at=0.0, surge="held", **row)
    middle, found = held_gains(model, about(y=[0.0]))[0], held_gains(model, about(y=y))
    return np.array([middle if gains is None else gains for gains in found], float)


MADE: dict[str, Callable[..., TrialHelm]] = {REGULATOR: _regulator, TRACK: _track}
