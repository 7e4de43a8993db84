"""The paper's table of terms, and those of the hull that data have asked for beside it."""

from narrows.physics import damping, inertia
from narrows.quantities import dimensions as dim
from narrows.terms.about import DRIFT_FORCE, DRIFT_MOMENT, YAW_MOMENT, ScaleEffect, TermKind
from narrows.terms.bank_forms import FORMS, PAPER_TEXT
from narrows.terms.term import FREE, NONNEGATIVE, Term, TermTable

USUAL = "the usual 3-DOF models, as in Fossen (2011), section 6.5"
INERTIA, RESISTANCE, DAMPING, LIFT, CROSS = (
    TermKind.INERTIA, TermKind.RESISTANCE, TermKind.DAMPING, TermKind.LIFT, TermKind.CROSSFLOW,
)  # fmt: skip
FRICTION, DRAG, TEST_SPEED = ScaleEffect.FRICTION, ScaleEffect.CROSSFLOW_DRAG, ScaleEffect.TEST_SPEED

SURGE = (
    Term("a_udot", r"a_{\dot u}", inertia.surge_inertia, dim.KG, NONNEGATIVE, INERTIA, PAPER_TEXT),
    Term("a_u", r"a_u", damping.linear_surge, dim.KG_PER_S, NONNEGATIVE, RESISTANCE, PAPER_TEXT),
    Term("a_uu", r"a_{|u|u}", damping.quadratic_surge, dim.KG_PER_M, NONNEGATIVE, RESISTANCE, PAPER_TEXT,
         scale_effect=FRICTION),
)  # fmt: skip
SWAY = (
    Term("b_vdot", r"b_{\dot v}", inertia.sway_inertia, dim.KG, NONNEGATIVE, INERTIA, PAPER_TEXT),
    Term("b_rdot", r"b_{\dot r}", inertia.yaw_inertia, dim.KG_M, FREE, INERTIA, PAPER_TEXT),
    Term("b_v", r"b_v", damping.linear_sway, dim.KG_PER_S, NONNEGATIVE, DAMPING, PAPER_TEXT, DRIFT_FORCE, TEST_SPEED),
    Term("b_r", r"b_r", damping.linear_yaw, dim.KG_M_PER_S, FREE, DAMPING, PAPER_TEXT, scale_effect=TEST_SPEED),
    Term("b_vv", r"b_{|v|v}", damping.quadratic_sway, dim.KG_PER_M, NONNEGATIVE, DAMPING, PAPER_TEXT,
         scale_effect=DRAG),
    Term("b_rr", r"b_{|r|r}", damping.quadratic_yaw, dim.KG_M, FREE, DAMPING, PAPER_TEXT),
    *FORMS["delta"].sway,
)  # fmt: skip
YAW = (
    Term("c_vdot", r"c_{\dot v}", inertia.sway_inertia, dim.KG_M, FREE, INERTIA, PAPER_TEXT),
    Term("c_rdot", r"c_{\dot r}", inertia.yaw_inertia, dim.KG_M2, NONNEGATIVE, INERTIA, PAPER_TEXT),
    Term("c_v", r"c_v", damping.linear_sway, dim.KG_M_PER_S, FREE, DAMPING, PAPER_TEXT, DRIFT_MOMENT, TEST_SPEED),
    Term("c_r", r"c_r", damping.linear_yaw, dim.KG_M2_PER_S, NONNEGATIVE, DAMPING, PAPER_TEXT, YAW_MOMENT, TEST_SPEED),
    Term("c_vv", r"c_{|v|v}", damping.quadratic_sway, dim.KG, FREE, DAMPING, PAPER_TEXT, scale_effect=DRAG),
    Term("c_rr", r"c_{|r|r}", damping.quadratic_yaw, dim.KG_M2, NONNEGATIVE, DAMPING, PAPER_TEXT),
    *FORMS["delta"].yaw,
)
# The paper states a_udot, b_vdot, c_rdot >= 0 in the text and leaves them out of its optimisation problem;
# they are masses and inertias, so the table has them.
# The terms of Mikkelsen et al. (2025).
PAPER = TermTable("paper", SURGE, SWAY, YAW, ties=(("b_rdot", "c_vdot"),))

# The paper's terms and, beside its linear damping, the parts that grow with the speed: u v and u r.
MIXED = PAPER.with_terms(
    "mixed",
    sway=[
        Term("b_uv", r"b_{uv}", damping.sway_lift, dim.KG_PER_M, FREE, LIFT, USUAL, DRIFT_FORCE),
        Term("b_ur", r"b_{ur}", damping.yaw_lift, dim.KG, FREE, LIFT, USUAL),
    ],
    yaw=[
        Term("c_uv", r"c_{uv}", damping.sway_lift, dim.KG, FREE, LIFT, USUAL, DRIFT_MOMENT),
        Term("c_ur", r"c_{ur}", damping.yaw_lift, dim.KG_M, FREE, LIFT, USUAL, YAW_MOMENT),
    ],
)

# The paper's terms with u v and u r in place of v and r: at one speed the same, at several the hull's lift.
SPEED = MIXED.without("speed", lambda term: term.scale_effect is TEST_SPEED)

# Terms of the usual 3-DOF models: those of ``speed``, and the crossflow's mixed ones; v v, v r and r r in surge.
CROSSFLOW = SPEED.with_terms(
    "crossflow",
    surge=[
        Term("a_vv", r"a_{vv}", damping.sway_squared, dim.KG_PER_M, FREE, LIFT, USUAL),
        Term("a_vr", r"a_{vr}", damping.sway_yaw, dim.KG, FREE, LIFT, USUAL),
        Term("a_rr", r"a_{rr}", damping.yaw_squared, dim.KG_M, FREE, LIFT, USUAL),
    ],
    sway=[
        Term("b_vr", r"b_{|v|r}", damping.yaw_in_crossflow, dim.KG, FREE, CROSS, USUAL),
        Term("b_rv", r"b_{|r|v}", damping.sway_in_crossflow, dim.KG, FREE, CROSS, USUAL),
    ],
    yaw=[
        Term("c_vr", r"c_{|v|r}", damping.yaw_in_crossflow, dim.KG_M, FREE, CROSS, USUAL),
        Term("c_rv", r"c_{|r|v}", damping.sway_in_crossflow, dim.KG_M, FREE, CROSS, USUAL),
    ],
)
