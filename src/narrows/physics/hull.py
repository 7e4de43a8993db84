"""The hull of the MMG standard method: hydrodynamic derivatives in sway and yaw, and added masses."""

import math
from dataclasses import dataclass
from functools import cached_property

from narrows.quantities.names import Number

STANDSTILL = 1e-12  # A speed [m/s] that counts as zero, without a sense


def speed(u: Number, v: Number) -> Number:
    """Total speed through the water [m/s], (u^2 + v^2)^(1/2). Source: definition."""
    return (u * u + v * v) ** 0.5


def half_drift(u: Number, v: Number) -> Number:
    """Tangent of half the drift angle from the nearer end of the ship [1], at most 1. Source: sin a/(1 + cos a)."""
    return -v / (speed(u, v) + abs(u))


def drift(u: Number, v: Number) -> Number:
    """Drift angle [rad], arctan(-v/u) to 1e-7 at 45 degrees and 4e-4 at 90. Source: Pade approximant of half of it."""
    # By the half the angle stays finite where u passes through zero.
    slope = half_drift(u, v)
    square = slope * slope
    half = slope * (945 + square * (735 + 64 * square)) / (945 + square * (1050 + 225 * square))
    return 2 * half * u / (abs(u) + STANDSTILL)


def scale_force(length: Number, draft: Number, density: Number) -> Number:
    """Force scale of the method [kg/m], 1/2 rho L d. Source: Yasukawa and Yoshimura (2015)."""
    return 0.5 * density * length * draft


@dataclass(frozen=True)
class HullPower:
    """Force 1/2 rho L d U^2 v'^i r'^j L^k per unit [N, N m]. Source: Yasukawa and Yoshimura (2015), eqs. 17, 18."""

    sway: int
    yaw: int
    lever: int = 0

    @property
    def name(self) -> str:
        return f"hull_v{self.sway}_r{self.yaw}"

    def __call__(self, u: Number, v: Number, r: Number, length: Number, draft: Number, density: Number) -> Number:
        force = scale_force(length, draft, density) * length ** (self.yaw + self.lever)
        for factor, power in ((v, self.sway), (r, self.yaw)):
            force = force * factor**power if power else force
        left = 2 - self.sway - self.yaw
        return force * speed(u, v) ** left if left else force


def resistance(u: Number, v: Number, length: Number, draft: Number, density: Number) -> Number:
    """Resistance per unit of R_0' [N], -1/2 rho L d U^2. Source: Yasukawa and Yoshimura (2015), reversed astern."""
    # Straight ahead no rounding differs from that of u^2.
    return -scale_force(length, draft, density) * (abs(u) * u + v * v * u / (abs(u) + STANDSTILL))


def rigid_surge(udot: Number, v: Number, r: Number, mass: Number, x_g: Number) -> Number:
    """Surge force of the ship's mass on the carriage [N], -m (udot - v r - x_G r^2). Source: Newton, about midship."""
    return -mass * (udot - v * r - x_g * r * r)


def rigid_sway(vdot: Number, rdot: Number, u: Number, r: Number, mass: Number, x_g: Number) -> Number:
    """Sway force of the ship's mass on the carriage [N], -m (vdot + u r + x_G rdot). Source: Newton, about midship."""
    return -mass * (vdot + u * r + x_g * rdot)


def rigid_yaw(vdot: Number, rdot: Number, u: Number, r: Number, mass: Number, x_g: Number, inertia: Number) -> Number:
    """Yaw moment of the ship's mass on the carriage [N m]. Source: Newton, about midship."""
    return -inertia * rdot - mass * x_g * (vdot + u * r)


@dataclass(frozen=True)
class Product:
    """Regressor of a derivative: minus a product of velocities or accelerations, as in ``|v| r``; bars mark sizes.

    Source: Mikkelsen et al. (2025), Damping Force and Moment and eqs. (mass_inertia_x, mass_inertia_y, mass_inertia_z);
    Fossen (2011), section 6.5, for lift and crossflow drag.
    """

    factors: str  # The paper once prints + for -c_rdot rdot; its regression matrix and the physics have -

    @property
    def name(self) -> str:
        return f"(-{self.factors})"

    @cached_property
    def inputs(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(factor.strip("|") for factor in self.factors.split()))

    @cached_property
    def _parts(self) -> tuple[tuple[int, bool], ...]:
        """Place among the inputs of each factor, and whether it is a size."""
        words = self.factors.split()
        return tuple((self.inputs.index(word.strip("|")), word.startswith("|")) for word in words)

    def __call__(self, *values: Number) -> Number:
        first, *others = (abs(values[place]) if is_size else values[place] for place, is_size in self._parts)
        return math.prod(others, start=-first)


@dataclass(frozen=True)
class AddedMass:
    """Force of an added mass per unit of m_x' or m_y' [N], moment of an added inertia per unit of J_z' [N m].

    Source: Yasukawa and Yoshimura (2015), eq. (4).
    """

    factors: str  # Velocities and accelerations
    power: int = 1  # Power of the length in the scale 1/2 rho L d L^power
    is_ahead: bool = False  # True for v r, which pushes ahead

    @property
    def name(self) -> str:
        return f"added_mass({self.factors})"

    @property
    def inputs(self) -> tuple[str, ...]:
        return (*self.factors.split(), "length", "draft", "density")

    def __call__(self, *values: Number) -> Number:
        *motion, length, draft, density = values
        scale = scale_force(length, draft, density) * length**self.power
        return math.prod(motion, start=scale if self.is_ahead else -scale)


# Added mass and inertia of a hull in deep water, by regression over ships.
def clarke_sway(length: float, beam: float, draft: float, block_coefficient: float, density: float) -> float:
    """Added mass in sway in deep water [kg]. Source: Clarke, Gedling and Hine (1983)."""
    slender = 1 + 0.16 * block_coefficient * beam / draft - 5.1 * (beam / length) ** 2
    return math.pi * (draft / length) ** 2 * slender * density * length**3 / 2


def clarke_yaw(length: float, beam: float, draft: float, block_coefficient: float, density: float) -> float:
    """Added moment of inertia in yaw about midship in deep water [kg m2]. Source: Clarke, Gedling and Hine (1983)."""
    slender = 1 / 12 + 0.017 * block_coefficient * beam / draft - 0.33 * beam / length
    return math.pi * (draft / length) ** 2 * slender * density * length**5 / 2


def current_gradient(
    cos_psi: Number, sin_psi: Number, u: Number, v: Number, across_slope: Number, shear: Number
) -> tuple[Number, Number, Number]:
    """Return what a current that is not the same everywhere does to a hull: turn [1/s], accelerations [m/s2].

    The water turns along the hull at ``turn``: the hull forces depend on the yaw rate less this. Its change takes the
    accelerations ahead and to starboard from a mass. ``across_slope`` [1/s] is the rise of the current across along the
    way, ``shear`` [1/s] that of the current along to starboard. Source: Thomasson and Woolsey (2013), Vehicle motion in
    currents, IEEE Journal of Oceanic Engineering, for the inertia in a flow with gradients; Fossen (2011), Handbook of
    marine craft hydrodynamics and motion control, for a uniform current, which leaves the equations of the velocity
    through the water as they are.
    """
    # The gradient G of the current acts on the velocity w through the water. A floating ship displaces its own mass of
    # water, so m (d/dt of the current that it meets) less the pressure of the accelerating water leaves m G w. The hull
    # forces, Coriolis forces among them, take the yaw rate less turn; the rigid body turns by the whole of it.
    along, off = shear * (u * sin_psi + v * cos_psi), across_slope * (u * cos_psi - v * sin_psi)
    turn = across_slope * cos_psi * cos_psi - shear * sin_psi * sin_psi
    return turn, along * cos_psi + off * sin_psi - turn * v, off * cos_psi - along * sin_psi + turn * u
