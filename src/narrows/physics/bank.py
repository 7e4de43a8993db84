"""The bank effect: suction to the near bank, and the cushion that turns the bow away from it.

Any parameter that says how much lower the pressure is on the side of the nearer bank makes a force and a moment by
one law; the parameters are in ``clearance``.
"""

from narrows.quantities.names import Number


def suction(
    pressure: Number, u: Number, heave: Number, length: Number, draft: Number, block_coefficient: Number,
    density: Number,
) -> Number:  # fmt: skip
    """Sway force of the bank [N] per unit coefficient and pressure parameter.

    The paper leaves u_w open: here it is the surge velocity through the water.

    Source: Mikkelsen et al. (2025), eq. (bank_sway_w_assum), for delta.
    """
    side = length * (draft + heave)
    return 0.5 * block_coefficient * density * side * pressure * (u * u)


def cushion(
    pressure: Number, u: Number, heave: Number, length: Number, draft: Number, block_coefficient: Number,
    density: Number,
) -> Number:  # fmt: skip
    """Yaw moment of the bank [N m] per unit coefficient, -L times the sway force of the same parameter.

    The paper prints both signs; this one, of its regression matrix, turns the bow away from the bank.

    Source: Mikkelsen et al. (2025), Theta_N, for delta.
    """
    return -length * suction(pressure, u, heave, length, draft, block_coefficient, density)
