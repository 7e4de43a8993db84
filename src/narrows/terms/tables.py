"""The tables of terms that come with the package: the paper's, and others that data have asked for."""

from dataclasses import replace

from narrows.errors import InputError, did_you_mean
from narrows.physics import damping, hull, inertia, propeller, rudder
from narrows.physics.propeller import PropellerQuantities
from narrows.physics.rudder import RudderQuantities
from narrows.quantities import dimensions as dim
from narrows.terms.bank_forms import FORMS, WITH_HELM, with_bank
from narrows.terms.regressors import Grouped
from narrows.terms.term import NONNEGATIVE, Term, TermTable

SURGE_POWERS = (("vv", (2, 0)), ("vr", (1, 1)), ("rr", (0, 2)), ("vvvv", (4, 0)))
TURNING_POWERS = (
    ("v", (1, 0)), ("r", (0, 1)), ("vvv", (3, 0)), ("vvr", (2, 1)), ("vrr", (1, 2)), ("rrr", (0, 3)),
)  # fmt: skip
"""Powers of v' and r' in the hull's forces of the MMG standard method."""
SURGE = (
    Term("a_udot", r"a_{\dot u}", inertia.surge_inertia, dim.KG, NONNEGATIVE),
    Term("a_u", r"a_u", damping.linear_surge, dim.KG_PER_S, NONNEGATIVE),
    Term("a_uu", r"a_{|u|u}", damping.quadratic_surge, dim.KG_PER_M, NONNEGATIVE),
)
SWAY = (
    Term("b_vdot", r"b_{\dot v}", inertia.sway_inertia, dim.KG, NONNEGATIVE),
    Term("b_rdot", r"b_{\dot r}", inertia.yaw_inertia, dim.KG_M),
    Term("b_v", r"b_v", damping.linear_sway, dim.KG_PER_S, NONNEGATIVE),
    Term("b_r", r"b_r", damping.linear_yaw, dim.KG_M_PER_S),
    Term("b_vv", r"b_{|v|v}", damping.quadratic_sway, dim.KG_PER_M, NONNEGATIVE),
    Term("b_rr", r"b_{|r|r}", damping.quadratic_yaw, dim.KG_M),
    *FORMS["delta"].sway,
)
YAW = (
    Term("c_vdot", r"c_{\dot v}", inertia.sway_inertia, dim.KG_M),
    Term("c_rdot", r"c_{\dot r}", inertia.yaw_inertia, dim.KG_M2, NONNEGATIVE),
    Term("c_v", r"c_v", damping.linear_sway, dim.KG_M_PER_S),
    Term("c_r", r"c_r", damping.linear_yaw, dim.KG_M2_PER_S, NONNEGATIVE),
    Term("c_vv", r"c_{|v|v}", damping.quadratic_sway, dim.KG),
    Term("c_rr", r"c_{|r|r}", damping.quadratic_yaw, dim.KG_M2, NONNEGATIVE),
    *FORMS["delta"].yaw,
)
# The paper states a_udot, b_vdot, c_rdot >= 0 in the text and leaves them out of its optimisation problem;
# they are masses and inertias, so the table has them.
PAPER = TermTable("paper", SURGE, SWAY, YAW, ties=(("b_rdot", "c_vdot"),))
"""The terms of Mikkelsen et al. (2025)."""

MIXED = PAPER.with_terms(
    "mixed",
    sway=[
        Term("b_uv", r"b_{uv}", damping.sway_lift, dim.KG_PER_M),
        Term("b_ur", r"b_{ur}", damping.yaw_lift, dim.KG),
    ],
    yaw=[
        Term("c_uv", r"c_{uv}", damping.sway_lift, dim.KG),
        Term("c_ur", r"c_{ur}", damping.yaw_lift, dim.KG_M),
    ],
)
"""The paper's terms and, beside its linear damping, the parts that grow with the speed: u v and u r."""

SPEED = replace(
    MIXED,
    name="speed",
    sway=tuple(term for term in MIXED.sway if term.name not in ("b_v", "b_r")),
    yaw=tuple(term for term in MIXED.yaw if term.name not in ("c_v", "c_r")),
)
"""The paper's terms with u v and u r in place of v and r: at one speed the same, at several the hull's lift."""

CROSSFLOW = SPEED.with_terms(
    "crossflow",
    surge=[
        Term("a_vv", r"a_{vv}", damping.sway_squared, dim.KG_PER_M),
        Term("a_vr", r"a_{vr}", damping.sway_yaw, dim.KG),
        Term("a_rr", r"a_{rr}", damping.yaw_squared, dim.KG_M),
    ],
    sway=[
        Term("b_vr", r"b_{|v|r}", damping.yaw_in_crossflow, dim.KG),
        Term("b_rv", r"b_{|r|v}", damping.sway_in_crossflow, dim.KG),
    ],
    yaw=[
        Term("c_vr", r"c_{|v|r}", damping.yaw_in_crossflow, dim.KG_M),
        Term("c_rv", r"c_{|r|v}", damping.sway_in_crossflow, dim.KG_M),
    ],
)
"""Terms of the usual 3-DOF models: those of ``speed``, and the crossflow's mixed ones; v v, v r and r r in surge."""

HELM = {
    "surge": (Term("a_helm", r"a_{helm}", rudder.helm_surge, dim.NUMBER, NONNEGATIVE),),
    "sway": (Term("b_helm", r"b_{helm}", rudder.helm_sway, dim.NUMBER, NONNEGATIVE),),
    "yaw": (Term("c_helm", r"c_{helm}", rudder.helm_yaw, dim.NUMBER, NONNEGATIVE),),
}
"""The terms of a rudder."""


def with_helm(table: TermTable, name: str = "") -> TermTable:
    """Return a table with the terms of a rudder (ours).

    Parameters
    ----------
    table : TermTable
        The table.
    name : str
        Of the new table; ``table+helm`` unless given.
    """
    return table.with_terms(name or f"{table.name}+{WITH_HELM}", **HELM)


STEERED = with_helm(CROSSFLOW, "steered")
"""The terms of ``crossflow`` and a rudder."""

MMG = TermTable(
    "mmg",
    surge=(
        Term("X_mass", r"m", hull.rigid_surge, dim.NUMBER, NONNEGATIVE),
        Term("X_mx", r"m_x'", hull.added_surge, dim.NUMBER, NONNEGATIVE),
        Term("X_my", r"m_y'", hull.added_sway_turning, dim.NUMBER, NONNEGATIVE),
        Term("R_0", r"R_0'", hull.HullPower(0, 0, sign=-1), dim.NUMBER, NONNEGATIVE),
        *(Term(f"X_{name}", rf"X_{{{name}}}'", hull.HullPower(*powers), dim.NUMBER) for name, powers in SURGE_POWERS),
        Term("X_thrust", r"1 - t_P", Grouped(propeller.thrust, PropellerQuantities), dim.NUMBER, NONNEGATIVE),
        Term("X_rudder", r"1 - t_R", Grouped(rudder.rudder_surge, RudderQuantities), dim.NUMBER, NONNEGATIVE),
    ),
    sway=(
        Term("Y_mass", r"m", hull.rigid_sway, dim.NUMBER, NONNEGATIVE),
        Term("Y_my", r"m_y'", hull.added_sway, dim.NUMBER, NONNEGATIVE),
        Term("Y_mx", r"m_x'", hull.added_surge_turning, dim.NUMBER, NONNEGATIVE),
        *(Term(f"Y_{name}", rf"Y_{{{name}}}'", hull.HullPower(*powers), dim.NUMBER) for name, powers in TURNING_POWERS),
        Term("Y_rudder", r"1 + a_H", Grouped(rudder.rudder_sway, RudderQuantities), dim.NUMBER, NONNEGATIVE),
    ),
    yaw=(
        Term("N_mass", r"I_z", hull.rigid_yaw, dim.NUMBER, NONNEGATIVE),
        Term("N_jz", r"J_z'", hull.added_yaw, dim.NUMBER, NONNEGATIVE),
        *(Term(f"N_{name}", rf"N_{{{name}}}'", hull.HullPower(*p, lever=1), dim.NUMBER) for name, p in TURNING_POWERS),
        Term("N_rudder", r"-(x_R' + a_H x_H')", Grouped(rudder.rudder_yaw, RudderQuantities), dim.NUMBER, NONNEGATIVE),
    ),
    ties=(("X_mass", "Y_mass"), ("X_mass", "N_mass"), ("X_mx", "Y_mx"), ("X_my", "Y_my")),
)
"""The MMG standard method, in open water: a hull by its primes, a propeller, a rudder in its slipstream."""

TAPERED = with_bank(PAPER, "tapered", name="tapered")
"""The paper's terms with its boundary-layer taper on the bank."""

BARE = {table.name: table for table in (PAPER, SPEED, MIXED, CROSSFLOW)}
"""The tables whose bank term is the paper's, for other forms of it to take its place."""
BASES = {**BARE, "steered": STEERED}
TABLES = {**BASES, "tapered": TAPERED, "mmg": MMG}
"""The tables by name; ``speed+keel_gap`` is the table ``speed`` with another form of the bank term."""


def table_named(name: str) -> TermTable:
    """Return a table of terms that comes with the package.

    Parameters
    ----------
    name : str
        Of a table, ``table+form`` for one with another form of the bank term, ``table+helm`` for one with a rudder.

    Raises
    ------
    InputError
        Where there is no such table or form.
    """
    base, *additions = name.split("+")
    known = BASES if set(additions) & set(FORMS) else TABLES
    if base not in known:
        raise InputError(f"unknown table of terms {base!r}{did_you_mean(base, known)}")
    table = TABLES[base]
    for addition in additions:
        if addition not in (*FORMS, WITH_HELM):
            raise InputError(f"unknown form {addition!r} of the bank term{did_you_mean(addition, [*FORMS, WITH_HELM])}")
        table = with_helm(table) if addition == WITH_HELM else with_bank(table, addition)
    return table
