"""Where the banks are, seen from a ship with heading psi, and what that does to the pressure."""

import math

from narrows.vocabulary import Number, documented


@documented
def starboard_clearance(y: Number, cos_psi: Number, width: Number, beam: Number) -> Number:
    """Midship hull clearance to the starboard bank [m], y_s = (W/2 - y) sec|psi| - B/2.

    Source: Mikkelsen et al. (2025), eq. (clearance_w_heading).
    """
    return (width / 2 - y) / cos_psi - beam / 2


@documented
def port_clearance(y: Number, cos_psi: Number, width: Number, beam: Number) -> Number:
    """Midship hull clearance to the port bank [m], y_p = (W/2 + y) sec|psi| - B/2.

    Source: Mikkelsen et al. (2025), eq. (clearance_w_heading).
    """
    return starboard_clearance(-y, cos_psi, width, beam)


@documented
def delta(y: Number, cos_psi: Number, width: Number, beam: Number) -> Number:
    """Pressure on the port side less that on the starboard side, over the dynamic pressure [1].

    The paper's ((y_s + B/2)/y_s)^2 - ((y_p + B/2)/y_p)^2, brought over one denominator:
    B c y (W (W - B c)/2 - 2 y^2) / (((W - B c)/2)^2 - y^2)^2 with c = cos psi. The same number to rounding,
    with one division, exactly odd in y, and zero at 90 degrees of heading without a secant.

    Source: Mikkelsen et al. (2025), eqs. (Delta_1) and (clearance_w_heading); the closed form is ours.
    """
    shadow = beam * cos_psi
    half_gap = (width - shadow) / 2
    room = half_gap * half_gap - y * y
    return shadow * y * (width * half_gap - 2 * y * y) / (room * room)


@documented
def taper(y: Number, width: Number) -> Number:
    """Boundary-layer taper near a wall [1], 1/2 - 1/2 tanh(5 (|y| - 2.5)) for a canal 7 m wide.

    The paper gives its two numbers for that tank alone; here they scale with the width (ours), so that a
    geosim of the tank tapers at the same relative place.

    Source: Mikkelsen et al. (2025), red curve of fig. (Delta_fun).
    """
    steepness, midpoint = 5 * 7 / width, 2.5 / 7 * width
    return 1 / (1 + math.e ** (2 * steepness * (abs(y) - midpoint)))
