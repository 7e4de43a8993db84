"""Distances to the banks, and the pressure difference that they cause between the sides of the ship."""

import math

from narrows.physics.squat_and_depth import water_past_the_ship
from narrows.quantities.names import GRAVITY, Number


def delta(y: Number, cos_psi: Number, width: Number, beam: Number) -> Number:
    """Pressure on the port side less that on the starboard side, over the dynamic pressure [1].

    The paper's ((y_s + B/2)/y_s)^2 - ((y_p + B/2)/y_p)^2, brought over one denominator: B c y (W (W - B c)/2 - 2 y^2) /
    (((W - B c)/2)^2 - y^2)^2 with c = cos psi. The same number to rounding, with one division, exactly odd in y, and
    zero at 90 degrees of heading without a secant. Source: Mikkelsen et al. (2025), eqs. (Delta_1) and
    (clearance_w_heading).
    """
    shadow = beam * cos_psi
    half_gap = (width - shadow) / 2
    room = half_gap * half_gap - y * y
    return shadow * y * (width * half_gap - 2 * y * y) / (room * room)


def taper(y: Number, width: Number) -> Number:
    """Boundary-layer taper near a wall [1], ``1/2 - 1/2 tanh(5 (|y| - 2.5))`` for a canal 7 m wide.

    The paper gives its two numbers for that tank alone; here they scale with the width, so that a geosim of the tank
    has its taper at the same relative place. Source: Mikkelsen et al. (2025), red curve of fig. (Delta_fun).
    """
    steepness, midpoint = 5 * 7 / width, 2.5 / 7 * width
    return 1 / (1 + math.e ** (2 * steepness * (abs(y) - midpoint)))


def tapered_delta(y: Number, cos_psi: Number, width: Number, beam: Number) -> Number:
    """Delta [1], fading in the boundary layer. Source: Mikkelsen et al. (2025), red curve of fig. (Delta_fun)."""
    return taper(y, width) * delta(y, cos_psi, width, beam)


def bank_distance(y: Number, cos_psi: Number, width: Number, beam: Number) -> Number:
    """Bank parameter y_B [1], B/2 (1/a - 1/p), with a and p from midship to the starboard and port bank.

    Far from the banks it is half of delta, which grows faster near one. Source: form of Ch'ng (1993) and Vantorre et
    al. (2003); over one denominator and with the heading.
    """
    half = width / 2
    return beam * cos_psi * y / (half * half - y * y)


def shallow_bank_distance(
    y: Number, cos_psi: Number, width: Number, beam: Number, draft: Number, depth: Number
) -> Number:
    """Parameter y_B times draft over under-keel clearance [1]. Source: form of Vantorre et al. (2003)."""
    return bank_distance(y, cos_psi, width, beam) * draft / (depth - draft)


def critical_bank_distance(y: Number, cos_psi: Number, u: Number, width: Number, beam: Number, depth: Number) -> Number:
    """Bank parameter y_B over (1 - F^2)^(1/2), growing towards the critical depth Froude number F = u/(g h)^(1/2) [1].

    Tuck's number F^2/(1 - F^2)^(1/2) times y_B, without the F^2 that the force's own u^2 contains. It is invalid for F
    >= 1. Source: form of Tuck (1966) as Lataire (2014) uses it.
    """
    return bank_distance(y, cos_psi, width, beam) / abs(1 - u * u / (GRAVITY * depth)) ** 0.5


def fast_bank_distance(
    y: Number, cos_psi: Number, u: Number, width: Number, beam: Number, draft: Number, depth: Number
) -> Number:
    """Parameter y_B times (U/u)^2 [1], with the speed U of the water past the ship. Invalid where the canal chokes.

    The force's own u^2 becomes U^2: a narrow section has more return flow than the tank, and a faster ship more still.
    Source: return flow of Schijf (1949).
    """
    share = water_past_the_ship(u, beam, draft, width, depth)
    return bank_distance(y, cos_psi, width, beam) / (share * share)


def keel_gap_delta(y: Number, cos_psi: Number, width: Number, beam: Number, draft: Number, depth: Number) -> Number:
    """Pressure difference delta [1] of a hull that blocks the same share of the depth, B -> B T/h.

    In the paper all water passes beside the hull; here some passes below it. At T = h both agree. Source: delta of
    Mikkelsen et al. (2025), with that beam.
    """
    return delta(y, cos_psi, width, beam * draft / depth)


def shallow_delta(y: Number, cos_psi: Number, width: Number, beam: Number, draft: Number, depth: Number) -> Number:
    """Delta times draft over under-keel clearance [1]. Source: the depth factor of Vantorre et al. (2003)."""
    return delta(y, cos_psi, width, beam) * draft / (depth - draft)


def suction(
    pressure: Number, u: Number, heave: Number, length: Number, draft: Number, block_coefficient: Number,
    density: Number,
) -> Number:  # fmt: skip
    """Sway force of the bank [N] per unit coefficient and pressure parameter.

    The paper does not define u_w: here it is the surge velocity through the water. Source: Mikkelsen et al. (2025), eq.
    (bank_sway_w_assum), for delta.
    """
    return _side(length, heave, draft, block_coefficient, density) * pressure * (u * u)


def cushion(
    pressure: Number, u: Number, heave: Number, length: Number, draft: Number, block_coefficient: Number,
    density: Number,
) -> Number:  # fmt: skip
    """Yaw moment of the bank [N m] per unit coefficient, -L times the sway force of the same parameter.

    The paper prints both signs; this one, of its regression matrix, turns the bow away from the bank. Astern it is the
    stern that leads and turns away, by the symmetry of bow and stern: ``u |u|`` instead of the paper's ``u^2``. Source:
    Mikkelsen et al. (2025), Theta_N, for delta.
    """
    return -length * _side(length, heave, draft, block_coefficient, density) * pressure * (u * abs(u))


def _side(length: Number, heave: Number, draft: Number, block_coefficient: Number, density: Number) -> Number:
    """Force on the side per unit of pressure parameter and squared speed [kg/m]."""
    return 0.5 * block_coefficient * density * length * (draft + heave)
