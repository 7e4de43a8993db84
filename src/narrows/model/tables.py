"""The tables of terms of the package, by name: hull, form of the bank term, rudder."""

from collections.abc import Callable
from functools import cache

from narrows.base.errors import InputError, did_you_mean
from narrows.model.additions import ADDED, AT, Grouped, pooled, with_helm
from narrows.model.bank_forms import FORMS, OPEN_WATER, PAPER_TEXT, with_bank, without_bank
from narrows.model.term import (
    DRIFT_FORCE,
    DRIFT_MOMENT,
    FREE,
    NONNEGATIVE,
    YAW_MOMENT,
    ScaleEffect,
    Term,
    TermKind,
    TermTable,
    without,
)
from narrows.physics import hull, propeller, rudder
from narrows.physics.hull import HullPower, Product
from narrows.physics.propeller import PropellerQuantities
from narrows.physics.rudder import RudderQuantities
from narrows.quantities import dimensions as dim
from narrows.quantities.dimensions import NUMBER
from narrows.quantities.names import Number

__all__ = ["BARE", "BASES", "CROSSFLOW", "MIXED", "MMG", "PAPER", "SPEED", "STEERED", "TAPERED", "table_named"]

# The paper's table of terms, and further hull terms that data required.
THREE_DOF = "the usual 3-DOF models, as in Fossen (2011), section 6.5"

INERTIA, RESISTANCE, DAMPING, LIFT, CROSS = (
    TermKind.INERTIA, TermKind.RESISTANCE, TermKind.DAMPING, TermKind.LIFT, TermKind.CROSSFLOW,
)  # fmt: skip

FRICTION, DRAG, TEST_SPEED = ScaleEffect.FRICTION, ScaleEffect.CROSSFLOW_DRAG, ScaleEffect.TEST_SPEED

SURGE = (
    Term("a_udot", r"a_{\dot u}", Product("udot"), dim.KG, NONNEGATIVE, INERTIA, PAPER_TEXT),
    Term("a_u", r"a_u", Product("u"), dim.KG_PER_S, NONNEGATIVE, RESISTANCE, PAPER_TEXT),
    Term("a_uu", r"a_{|u|u}", Product("|u| u"), dim.KG_PER_M, NONNEGATIVE, RESISTANCE, PAPER_TEXT,
         scale_effect=FRICTION),
)  # fmt: skip

SWAY = (
    Term("b_vdot", r"b_{\dot v}", Product("vdot"), dim.KG, NONNEGATIVE, INERTIA, PAPER_TEXT),
    Term("b_rdot", r"b_{\dot r}", Product("rdot"), dim.KG_M, FREE, INERTIA, PAPER_TEXT),
    Term("b_v", r"b_v", Product("v"), dim.KG_PER_S, NONNEGATIVE, DAMPING, PAPER_TEXT, DRIFT_FORCE, TEST_SPEED),
    Term("b_r", r"b_r", Product("r"), dim.KG_M_PER_S, FREE, DAMPING, PAPER_TEXT, scale_effect=TEST_SPEED),
    Term("b_vv", r"b_{|v|v}", Product("|v| v"), dim.KG_PER_M, NONNEGATIVE, DAMPING, PAPER_TEXT,
         scale_effect=DRAG),
    Term("b_rr", r"b_{|r|r}", Product("|r| r"), dim.KG_M, FREE, DAMPING, PAPER_TEXT),
    *FORMS["delta"].sway,
)  # fmt: skip

YAW = (
    Term("c_vdot", r"c_{\dot v}", Product("vdot"), dim.KG_M, FREE, INERTIA, PAPER_TEXT),
    Term("c_rdot", r"c_{\dot r}", Product("rdot"), dim.KG_M2, NONNEGATIVE, INERTIA, PAPER_TEXT),
    Term("c_v", r"c_v", Product("v"), dim.KG_M_PER_S, FREE, DAMPING, PAPER_TEXT, DRIFT_MOMENT, TEST_SPEED),
    Term("c_r", r"c_r", Product("r"), dim.KG_M2_PER_S, NONNEGATIVE, DAMPING, PAPER_TEXT, YAW_MOMENT, TEST_SPEED),
    Term("c_vv", r"c_{|v|v}", Product("|v| v"), dim.KG, FREE, DAMPING, PAPER_TEXT, scale_effect=DRAG),
    Term("c_rr", r"c_{|r|r}", Product("|r| r"), dim.KG_M2, NONNEGATIVE, DAMPING, PAPER_TEXT),
    *FORMS["delta"].yaw,
)

# The paper states a_udot, b_vdot, c_rdot >= 0 in the text and leaves them out of its optimisation problem; they are
# masses and inertias, so the table has them. The terms of Mikkelsen et al. (2025).
PAPER = TermTable("paper", SURGE, SWAY, YAW, ties=(("b_rdot", "c_vdot"),))

# The paper's terms with its linear damping and additional speed-dependent parts: u v and u r.
MIXED = PAPER.with_terms(
    "mixed",
    sway=[
        Term("b_uv", r"b_{uv}", Product("u v"), dim.KG_PER_M, FREE, LIFT, THREE_DOF, DRIFT_FORCE),
        Term("b_ur", r"b_{ur}", Product("u r"), dim.KG, FREE, LIFT, THREE_DOF),
    ],
    yaw=[
        Term("c_uv", r"c_{uv}", Product("u v"), dim.KG, FREE, LIFT, THREE_DOF, DRIFT_MOMENT),
        Term("c_ur", r"c_{ur}", Product("u r"), dim.KG_M, FREE, LIFT, THREE_DOF, YAW_MOMENT),
    ],
)

# The paper's terms with u v and u r in place of v and r: the same at one speed, the hull's lift at several.
SPEED = without(MIXED, "speed", lambda term: term.scale_effect is TEST_SPEED)

# Terms of the usual 3-DOF models: those of ``speed``, mixed crossflow terms, and v v, v r and r r in surge.
CROSSFLOW = SPEED.with_terms(
    "crossflow",
    surge=[
        Term("a_vv", r"a_{vv}", Product("v v"), dim.KG_PER_M, FREE, LIFT, THREE_DOF),
        Term("a_vr", r"a_{vr}", Product("v r"), dim.KG, FREE, LIFT, THREE_DOF),
        Term("a_rr", r"a_{rr}", Product("r r"), dim.KG_M, FREE, LIFT, THREE_DOF),
    ],
    sway=[
        Term("b_vr", r"b_{|v|r}", Product("|v| r"), dim.KG, FREE, CROSS, THREE_DOF),
        Term("b_rv", r"b_{|r|v}", Product("|r| v"), dim.KG, FREE, CROSS, THREE_DOF),
    ],
    yaw=[
        Term("c_vr", r"c_{|v|r}", Product("|v| r"), dim.KG_M, FREE, CROSS, THREE_DOF),
        Term("c_rv", r"c_{|r|v}", Product("|r| v"), dim.KG_M, FREE, CROSS, THREE_DOF),
    ],
)

# The terms of ``crossflow`` and a rudder.
STEERED = with_helm(CROSSFLOW, "steered")

# The tables of a hull without a rudder, with the paper's bank term.
BARE = {table.name: table for table in (PAPER, SPEED, MIXED, CROSSFLOW)}

# The MMG standard method as a table of terms.
SOURCE = "Yasukawa and Yoshimura (2015)"
LETTERS = ("X", "Y", "N")
# Powers of v' and r' in the hull's forces.
SURGE_POWERS = (("vv", (2, 0)), ("vr", (1, 1)), ("rr", (0, 2)), ("vvvv", (4, 0)))
TURNING_POWERS = (
    ("v", (1, 0)), ("r", (0, 1)), ("vvv", (3, 0)), ("vvr", (2, 1)), ("vrr", (1, 2)), ("rrr", (0, 3)),
)  # fmt: skip

# Depth laws of the derivatives that grow in shallow water.
DEPTH_LAWS = {"Y_v": DRIFT_FORCE, "N_v": DRIFT_MOMENT, "N_r": YAW_MOMENT}
WAKE = ScaleEffect.WAKE


def _mass(name: str, symbol: str, regressor: Callable[..., Number]) -> Term:
    return Term(name, symbol, regressor, NUMBER, NONNEGATIVE, TermKind.INERTIA, SOURCE)


def _polynomial(letter: str, powers: tuple[tuple[str, tuple[int, int]], ...], lever: int = 0) -> tuple[Term, ...]:
    return tuple(
        Term(
            f"{letter}_{word}", f"{letter}_{{{word}}}'", HullPower(*exponents, lever=lever), NUMBER, FREE,
            TermKind.HULL, SOURCE, DEPTH_LAWS.get(f"{letter}_{word}"),
            scale_effect=ScaleEffect.CROSSFLOW_DRAG if exponents == (3, 0) else None,  # Drag of a bluff section
        )
        for word, exponents in powers
    )  # fmt: skip


def _rudder(name: str, symbol: str, force: Callable[[RudderQuantities], Number]) -> Term:
    regressor = Grouped(force, RudderQuantities)
    return Term(name, symbol, regressor, NUMBER, NONNEGATIVE, TermKind.RUDDER, SOURCE, scale_effect=WAKE)


# The MMG standard method in open water: a hull with nondimensional derivatives, a propeller, a rudder in its
# slipstream.
MMG = TermTable(
    "mmg",
    surge=(
        _mass("X_mass", r"m", hull.rigid_surge),
        _mass("X_mx", r"m_x'", hull.added_surge),
        _mass("X_my", r"m_y'", hull.added_sway_turning),
        Term(
            "R_0", r"R_0'", hull.resistance, NUMBER, NONNEGATIVE, TermKind.RESISTANCE, SOURCE,
            scale_effect=ScaleEffect.FRICTION,
        ),
        *_polynomial("X", SURGE_POWERS),
        Term("X_thrust", r"1 - t_P", Grouped(propeller.thrust, PropellerQuantities), NUMBER, NONNEGATIVE,
             TermKind.PROPELLER, SOURCE, scale_effect=WAKE),
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

# The tables by name; ``speed+keel_gap`` is the table ``speed`` with another form of the bank term.
BASES = {**BARE, "steered": STEERED, "mmg": MMG}
# Other names for some of them.
SHORT = {"tapered": "paper+tapered"}


@cache
def table_named(name: str) -> TermTable:
    if AT in name:
        base, _, depths = name.partition(AT)
        return pooled(table_named(base), _depths(depths, name))
    first, plus, rest = name.partition("+")
    base, *additions = (SHORT.get(first, first) + plus + rest).split("+")
    if base not in BASES:
        raise InputError(f"unknown table of terms {base!r}{did_you_mean(base, [*BASES, *SHORT])}")
    if unknown := [word for word in additions if word not in (*FORMS, OPEN_WATER, *ADDED)]:
        hint = did_you_mean(unknown[0], [*FORMS, OPEN_WATER, *ADDED])
        raise InputError(f"unknown form {unknown[0]!r} of the bank term{hint}")
    if sum(word not in ADDED for word in additions) > 1:
        raise InputError(f"the terms {name!r} have two forms of the bank; keep one")
    table = BASES[base]
    for addition in additions:
        if addition in ADDED:
            table = ADDED[addition](table)
        else:
            table = without_bank(table) if addition == OPEN_WATER else with_bank(table, addition)
    return table


def _depths(written: str, name: str) -> list[float]:
    try:
        return [float(part) for part in written.split(",")]
    except ValueError:
        raise InputError(f"the terms {name!r} give no depths in metres behind {AT}; write paper{AT}0.25,0.41") from None


# The paper's terms with its boundary-layer taper on the bank.
TAPERED = table_named("paper+tapered")
