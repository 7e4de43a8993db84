"""The balance of sway and yaw on steady legs: linear in the coefficients, with exact slopes by what was read."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from narrows.codegen.linearisation import LINEARISED
from narrows.control.self_propulsion import self_propulsion
from narrows.model.model import Model
from narrows.quantities.names import Number
from narrows.safety.question import keel_at
from narrows.ship.motion import Motion
from narrows.simulation.ship import SimulatedShip

# What a leg is, truly: what its readings are readings of.
LATENT = ("y", "u", "rudder", "psi")
# Forces that a steady leg has in balance, and the velocity whose rate each makes.
BALANCED = {"Y": "v", "N": "r"}


@dataclass(frozen=True)
class SteadyBalance:
    """Sway force and yaw moment of a model on legs, and their slopes."""

    model: Model  # With terms of a rudder
    felt: Mapping[str, np.ndarray]  # (legs,) Heave [m], and revolutions [1/s] where the terms ask for them

    @cached_property
    def _ship(self) -> SimulatedShip:
        return SimulatedShip(self.model)

    @cached_property
    def _particulars(self) -> dict[str, Number]:
        return {**self._ship.values(), **self.felt}

    def columns(self, latent: np.ndarray) -> np.ndarray:
        """Return what multiplies each coefficient in sway force and yaw moment, (legs, 2, coefficients)."""
        # latent (legs, 4)
        names = self.model.terms.names
        values, columns = self._values(latent), np.zeros((len(latent), len(BALANCED), len(names)))
        for row, force in enumerate(BALANCED):
            for term in self.model.terms.forces[force]:
                columns[:, row, names.index(term.name)] = term.column(values)
        return columns

    def slopes(self, latent: np.ndarray, coefficients: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return slopes by ``LATENT`` (legs, 2, 4) and by the yaw rate (legs, 2), and the mass (legs, 2, 2)."""
        # latent (legs, 4); coefficients (coefficients,)
        # Along a straight course: the sway velocity goes with heading and speed.
        named = dict(zip(self.model.terms.names, coefficients.tolist(), strict=True))
        linear = self._ship.linearisation({**self._particulars, **named})
        y, u, rudder, psi = latent.T
        at = {"y": y, "u": u, "v": -u * np.tan(psi), "psi": psi, "rudder": rudder, **self.felt}
        # The rates are the forces over the mass, which no place changes.
        rates = linear.linear(at)[:, [LINEARISED.index(velocity) for velocity in BALANCED.values()]]
        names = (*LINEARISED, *linear.controlled)
        mass = np.linalg.inv(rates[:, :, [names.index("Y_in"), names.index("N_in")]])
        by = dict(zip(names, np.moveaxis(mass @ rates, 2, 0), strict=True))
        by_u = by["u"] - by["v"] * np.tan(psi)[:, None]
        by_psi = by["psi"] - by["v"] * (u / np.cos(psi) ** 2)[:, None]
        return np.stack([by["y"], by_u, by["rudder"], by_psi], axis=-1), by["r"], mass

    def _values(self, latent: np.ndarray) -> dict[str, Number]:
        y, u, rudder, psi = latent.T
        values = {**self._particulars, **Motion.at(psi, y=y, u=u, v=-u * np.tan(psi)).values(), **self.felt}
        for actuator in self.model.terms.actuators:
            if actuator.name == "rudder":
                values |= actuator.placed(rudder)
        return values


def felt_on(model: Model, speeds: np.ndarray, told: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return what goes with the speed of legs: heave [m], and revolutions [1/s] where the terms ask for them."""
    # speeds (legs,) [m/s]
    each, place = np.unique(speeds, return_inverse=True)
    felt = {"heave": told["heave"] if "heave" in told else keel_at(model, each).midship[place]}
    if model.terms.propelled:
        turns = told.get("revolutions")
        if turns is None:
            turns = np.array([self_propulsion(model, speed) for speed in each.tolist()])[place]
        felt["revolutions"] = turns
    return felt
