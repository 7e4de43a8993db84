"""The MMG standard method as a table of terms."""

from collections.abc import Callable

from narrows.physics import hull, propeller, rudder
from narrows.physics.hull import HullPower
from narrows.physics.propeller import PropellerQuantities
from narrows.physics.rudder import RudderQuantities
from narrows.quantities.dimensions import NUMBER
from narrows.quantities.names import Number
from narrows.terms.about import DRIFT_FORCE, DRIFT_MOMENT, YAW_MOMENT, ScaleEffect, TermKind
from narrows.terms.regressors import Grouped
from narrows.terms.term import FREE, NONNEGATIVE, Term, TermTable

SOURCE = "Yasukawa and Yoshimura (2015)"
LETTERS = ("X", "Y", "N")
SURGE_POWERS = (("vv", (2, 0)), ("vr", (1, 1)), ("rr", (0, 2)), ("vvvv", (4, 0)))
# Powers of v' and r' in the hull's forces.
TURNING_POWERS = (
    ("v", (1, 0)), ("r", (0, 1)), ("vvv", (3, 0)), ("vvr", (2, 1)), ("vrr", (1, 2)), ("rrr", (0, 3)),
)  # fmt: skip
# The powers of what a bluff section drags.
CROSSFLOW_DRAG = (3, 0)
# Of the derivatives that are known to grow as the water gets shallow.
DEPTH_LAWS = {"Y_v": DRIFT_FORCE, "N_v": DRIFT_MOMENT, "N_r": YAW_MOMENT}
WAKE = ScaleEffect.WAKE


def _mass(name: str, symbol: str, regressor: Callable[..., Number]) -> Term:
    return Term(name, symbol, regressor, NUMBER, NONNEGATIVE, TermKind.INERTIA, SOURCE)


def _polynomial(letter: str, powers: tuple[tuple[str, tuple[int, int]], ...], lever: int = 0) -> tuple[Term, ...]:
    return tuple(
        Term(
            f"{letter}_{word}", f"{letter}_{{{word}}}'", HullPower(*exponents, lever=lever), NUMBER, FREE,
            TermKind.HULL, SOURCE, DEPTH_LAWS.get(f"{letter}_{word}"),
            scale_effect=ScaleEffect.CROSSFLOW_DRAG if exponents == CROSSFLOW_DRAG else None,
        )
        for word, exponents in powers
    )  # fmt: skip


def _rudder(name: str, symbol: str, force: Callable[[RudderQuantities], Number]) -> Term:
    regressor = Grouped(force, RudderQuantities)
    return Term(name, symbol, regressor, NUMBER, NONNEGATIVE, TermKind.RUDDER, SOURCE, scale_effect=WAKE)


THRUST = Grouped(propeller.thrust, PropellerQuantities)
# The MMG standard method, in open water: a hull by its primes, a propeller, a rudder in its slipstream.
MMG = TermTable(
    "mmg",
    surge=(
        _mass("X_mass", r"m", hull.rigid_surge),
        _mass("X_mx", r"m_x'", hull.added_surge),
        _mass("X_my", r"m_y'", hull.added_sway_turning),
        Term(
            "R_0", r"R_0'", HullPower(0, 0, sign=-1), NUMBER, NONNEGATIVE, TermKind.RESISTANCE, SOURCE,
            scale_effect=ScaleEffect.FRICTION,
        ),
        *_polynomial("X", SURGE_POWERS),
        Term("X_thrust", r"1 - t_P", THRUST, NUMBER, NONNEGATIVE, TermKind.PROPELLER, SOURCE, scale_effect=WAKE),
        _rudder("X_rudder", r"1 - t_R", rudder.rudder_surge),
    ),
    sway=(
        _mass("Y_mass", r"m", hull.rigid_sway),
        _mass("Y_my", r"m_y'", hull.added_sway),
        _mass("Y_mx", r"m_x'", hull.added_surge_turning),
        *_polynomial("Y", TURNING_POWERS),
        _rudder("Y_rudder", r"1 + a_H", rudder.rudder_sway),
    ),
    yaw=(
        _mass("N_mass", r"I_z", hull.rigid_yaw),
        _mass("N_jz", r"J_z'", hull.added_yaw),
        *_polynomial("N", TURNING_POWERS, lever=1),
        _rudder("N_rudder", r"-(x_R' + a_H x_H')", rudder.rudder_yaw),
    ),
    ties=(("X_mass", "Y_mass"), ("X_mass", "N_mass"), ("X_mx", "Y_mx"), ("X_my", "Y_my")),
    letters=LETTERS,
)  # fmt: skip
