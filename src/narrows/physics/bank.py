"""The bank effect: suction to the near bank, and the cushion that turns the bow away from it."""

from narrows.physics.clearance import delta, taper
from narrows.vocabulary import Number, documented


@documented
def suction(
    y: Number, cos_psi: Number, u: Number, heave: Number,
    length: Number, beam: Number, draft: Number, block_coefficient: Number, width: Number, density: Number,
) -> Number:  # fmt: skip
    """Sway force of the bank [N] per unit b_bank, 1/2 C_B rho L (T0 + z) delta u_w^2.

    The paper leaves u_w open: here it is the surge velocity through the water.

    Source: Mikkelsen et al. (2025), eq. (bank_sway_w_assum).
    """
    side = length * (draft + heave)
    return 0.5 * block_coefficient * density * side * delta(y, cos_psi, width, beam) * (u * u)


@documented
def cushion(
    y: Number, cos_psi: Number, u: Number, heave: Number,
    length: Number, beam: Number, draft: Number, block_coefficient: Number, width: Number, density: Number,
) -> Number:  # fmt: skip
    """Yaw moment of the bank [N m] per unit c_bank, -1/2 C_B rho L^2 (T0 + z) delta u_w^2.

    The paper prints both signs; this one, of its regression matrix, turns the bow away from the bank.

    Source: Mikkelsen et al. (2025), Theta_N.
    """
    return -length * suction(y, cos_psi, u, heave, length, beam, draft, block_coefficient, width, density)


@documented
def tapered_suction(
    y: Number, cos_psi: Number, u: Number, heave: Number,
    length: Number, beam: Number, draft: Number, block_coefficient: Number, width: Number, density: Number,
) -> Number:  # fmt: skip
    """Suction [N] per unit b_bank, fading in the boundary layer of a wall.

    Source: Mikkelsen et al. (2025), red curve of fig. (Delta_fun).
    """
    force = suction(y, cos_psi, u, heave, length, beam, draft, block_coefficient, width, density)
    return taper(y, width) * force


@documented
def tapered_cushion(
    y: Number, cos_psi: Number, u: Number, heave: Number,
    length: Number, beam: Number, draft: Number, block_coefficient: Number, width: Number, density: Number,
) -> Number:  # fmt: skip
    """Cushion [N m] per unit c_bank, fading in the boundary layer of a wall.

    Source: Mikkelsen et al. (2025), red curve of fig. (Delta_fun).
    """
    moment = cushion(y, cos_psi, u, heave, length, beam, draft, block_coefficient, width, density)
    return taper(y, width) * moment
