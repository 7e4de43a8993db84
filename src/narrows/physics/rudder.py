"""What turning the rudder adds to the force on a hull whose tests had it amidships, per unit of each coefficient.

The rudder's normal force is 1/2 rho A U_R (u_R sin delta - v_R cos delta), as in the MMG standard method; what it is
with the rudder amidships is the hull's already. The area stands as L T/100, and lift, wake, slipstream and the hull's
share are in the coefficients, so these hold for the propeller loading of the tests.
"""

from narrows.vocabulary import Number, documented

REFERENCE_AREA = 0.01
"""Of the rudder, over length times draft [1]."""


def _pressure(length: Number, draft: Number, density: Number) -> Number:
    return 0.5 * density * REFERENCE_AREA * length * draft


def _across(v: Number, r: Number, length: Number, flow_straightening: Number) -> Number:
    """Flow across the rudder at the stern, straightened by hull and propeller [m/s]."""
    return flow_straightening * (r * length / 2 - v)


def _normal(u: Number, across: Number, cos_rudder: Number, sin_rudder: Number) -> Number:
    """U_R (u sin delta - v_R cos delta) [m2/s2]."""
    return (u * u + across * across) ** 0.5 * (u * sin_rudder - across * cos_rudder)


@documented
def helm_surge(
    u: Number, v: Number, r: Number, cos_rudder: Number, sin_rudder: Number,
    length: Number, draft: Number, flow_straightening: Number, density: Number,
) -> Number:  # fmt: skip
    """Surge force [N] of the rudder per unit coefficient, -1/2 rho A U_R (u sin delta - v_R cos delta) sin delta.

    Source: form of Yasukawa and Yoshimura (2015), the MMG standard method.
    """
    across = _across(v, r, length, flow_straightening)
    return -_pressure(length, draft, density) * _normal(u, across, cos_rudder, sin_rudder) * sin_rudder


@documented
def helm_sway(
    u: Number, v: Number, r: Number, cos_rudder: Number, sin_rudder: Number,
    length: Number, draft: Number, flow_straightening: Number, density: Number,
) -> Number:  # fmt: skip
    """Sway force [N] that turning the rudder adds per unit coefficient: to port for a turn to starboard.

    Source: form of Yasukawa and Yoshimura (2015), the MMG standard method, less its value with the rudder amidships.
    """
    across = _across(v, r, length, flow_straightening)
    turned = _normal(u, across, cos_rudder, sin_rudder) * cos_rudder
    return -_pressure(length, draft, density) * (turned - _normal(u, across, 1.0, 0.0))


@documented
def helm_yaw(
    u: Number, v: Number, r: Number, cos_rudder: Number, sin_rudder: Number,
    length: Number, draft: Number, flow_straightening: Number, density: Number,
) -> Number:  # fmt: skip
    """Yaw moment [N m] that turning the rudder adds per unit coefficient, -L times the sway force.

    Source: form of Yasukawa and Yoshimura (2015), the MMG standard method, less its value with the rudder amidships.
    """
    return -length * helm_sway(u, v, r, cos_rudder, sin_rudder, length, draft, flow_straightening, density)
