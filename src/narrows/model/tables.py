"""The tables of terms of the package, by name: hull, form of the bank term with source and validity, rudder."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

from narrows.base.errors import InputError, did_you_mean
from narrows.base.named_values import by_name
from narrows.base.results import BaseSummary
from narrows.model.additions import ADDED, AT, HELM, Grouped, pooled
from narrows.model.term import (
    DRIFT_FORCE,
    DRIFT_MOMENT,
    FREE,
    LETTERS,
    NONNEGATIVE,
    YAW_MOMENT,
    ScaleEffect,
    Term,
    TermKind,
    TermTable,
    without,
)
from narrows.physics import clearance, hull
from narrows.physics import propeller_and_rudder as mmg
from narrows.physics.clearance import cushion, suction
from narrows.physics.hull import AddedMass, HullPower, Product
from narrows.quantities import names as dim
from narrows.quantities.names import NUMBER, Number, argument_names, evaluate, name_of


@dataclass(frozen=True)
class Composed:
    """A law whose first argument is the result of another function."""

    law: Callable[..., Number]  # Function of that result, then of names of the vocabulary
    parameter: Callable[..., Number]  # Function of names of the vocabulary

    @cached_property
    def inputs(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys((*argument_names(self.parameter), *argument_names(self.law)[1:])))

    @property
    def name(self) -> str:
        return f"{name_of(self.parameter)}_{name_of(self.law)}"

    def __call__(self, *values: Number) -> Number:
        at = dict(zip(self.inputs, values, strict=True))
        return self.law(evaluate(self.parameter, at), *[at[name] for name in argument_names(self.law)[1:]])


# Suffix of the name of a table without terms of the bank.
OPEN_WATER = "open_water"
PUBLISHED, REFITTED, NEW = "published", "form of another, coefficients refitted", "new in narrows"


@dataclass(frozen=True, repr=False)
class BankForm(BaseSummary):
    """A form of the bank term.

    Raises an InputError if its name is no plain word, or that of an addition to a table.

    >>> nw.FORMS["delta"].name
    'delta'
    """

    name: str  #: As in ``paper+keel_gap``
    #: Pressure parameters, by the coefficients' ending: ``bank`` for b_bank and c_bank
    parameters: Mapping[str, Callable[..., Number]]
    source: str  #: Its source
    validity: str  #: Range of validity
    status: str  #: ``published``, ``form of another, coefficients refitted`` or ``new in narrows``

    def __post_init__(self) -> None:
        if not re.fullmatch(r"[^\s+@]+", self.name) or self.name in (*ADDED, OPEN_WATER):
            raise InputError(f"a form of the bank term cannot be called {self.name!r}; give it a plain word of its own")

    def summary(self) -> str:
        return f"{self.name}, {self.status}: {self.source}"

    @property
    def sway(self) -> tuple[Term, ...]:
        """Terms of the sway force, with the paper's names."""
        return _bank_terms(self, LETTERS[1], suction)

    @property
    def yaw(self) -> tuple[Term, ...]:
        """Terms of the yaw moment, with the paper's names."""
        return _bank_terms(self, LETTERS[2], cushion)


def _bank_terms(form: BankForm, letter: str, law: Callable[..., Number]) -> tuple[Term, ...]:
    return tuple(
        Term(
            f"{letter}_{ending}", rf"{letter}_{{{ending.replace('_', ',')}}}", Composed(law, parameter), NUMBER,
            kind=TermKind.BANK, source=form.source, scale_effect=ScaleEffect.BANK_SHAPE,
        )
        for ending, parameter in form.parameters.items()
    )  # fmt: skip


PAPER_TEXT = "Mikkelsen et al. (2025)"
TWO = "h > T; two coefficients a force, so that the sign can change with depth"
# The forms by name.
FORMS = by_name(
    "forms of the bank term",
    ((form.name, form) for form in (
        BankForm("delta", {"bank": clearance.delta}, PAPER_TEXT, "clear of the banks; independent of depth", PUBLISHED),
        BankForm("tapered", {"bank": clearance.tapered_delta}, f"{PAPER_TEXT}, red curve of fig. (Delta_fun)",
                 "also within the boundary layer of a wall; independent of depth", PUBLISHED),
        BankForm("distance", {"bank": clearance.bank_distance}, "y_B of Ch'ng (1993) and Vantorre et al. (2003)",
                 "far from the banks; independent of depth", REFITTED),
        BankForm("distance_depth", {"bank": clearance.bank_distance, "bank_depth": clearance.shallow_bank_distance},
                 "y_B and y_B T/(h - T) of Vantorre et al. (2003)",
                 f"far from the banks, {TWO}", REFITTED),
        BankForm("tuck", {"bank": clearance.critical_bank_distance}, "y_B with Tuck's number, after Lataire (2014)",
                 "far from the banks, well below the critical speed (F < 0.7)", REFITTED),
        BankForm("return_flow", {"bank": clearance.fast_bank_distance}, "y_B with the return flow of Schijf (1949)",
                 "far from the banks, below the speed that chokes the canal", NEW),
        BankForm("keel_gap", {"bank": clearance.keel_gap_delta}, "delta with B T/h in place of B",
                 "h >= T; the paper's delta at T = h; no change of sign", NEW),
        BankForm("delta_depth", {"bank": clearance.delta, "bank_depth": clearance.shallow_delta},
                 "delta and delta T/(h - T)", TWO, NEW),
    )),
)  # fmt: skip


def with_bank(table: TermTable, form: str | BankForm, name: str = "") -> TermTable:
    """Return a table with another form of its bank term.

    Raises an InputError if there is no such form, or its name or that of a coefficient is another's.

    Parameters
    ----------
    table : TermTable
        The table; its own bank terms are replaced.
    form : str or BankForm
        One of ``FORMS``, or your own.
    name : str
        Name of the new table; ``table+form`` unless given.

    Examples
    --------
    >>> "b_bank" in nw.with_bank(nw.SPEED, "tuck").names
    True
    """
    if isinstance(form, str):
        if form not in FORMS:
            raise InputError(f"unknown form {form!r} of the bank term{did_you_mean(form, FORMS)}")
        form = FORMS[form]
    if FORMS.get(form.name, form) != form:
        raise InputError(f"there is a form {form.name!r} of the bank term already; rename yours")
    kept = without(table, name or f"{_base(table)}+{form.name}", lambda term: term.from_bank)
    _, of_sway, of_yaw = table.letters
    sway, yaw = _bank_terms(form, of_sway, suction), _bank_terms(form, of_yaw, cushion)
    for term in (*sway, *yaw):
        if term.name in kept.names:
            raise InputError(f"form {form.name}: {term.name} is a coefficient of {table.name} already; rename yours")
    return kept.with_terms(kept.name, sway=sway, yaw=yaw)


def without_bank(table: TermTable) -> TermTable:
    return without(table, f"{_base(table)}+{OPEN_WATER}", lambda term: term.from_bank)


def _base(table: TermTable) -> str:
    """The name of a table without its form of the bank."""
    base, *additions = table.name.split("+")
    return "+".join([base, *(word for word in additions if word in ADDED)])


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

STEERED = HELM(CROSSFLOW, "steered")  # The terms of ``crossflow`` and a rudder

# The tables of a hull without a rudder, with the paper's bank term.
BARE = {table.name: table for table in (PAPER, SPEED, MIXED, CROSSFLOW)}

# The MMG standard method as a table of terms.
SOURCE = "Yasukawa and Yoshimura (2015)"
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


def _rudder(name: str, symbol: str, force: Callable[[Any], Number]) -> Term:
    return Term(name, symbol, Grouped(force), NUMBER, NONNEGATIVE, TermKind.RUDDER, SOURCE, scale_effect=WAKE)


# The MMG standard method in open water: a hull with nondimensional derivatives, a propeller, a rudder in its
# slipstream.
MMG = TermTable(
    "mmg",
    surge=(
        _mass("X_mass", r"m", hull.rigid_surge),
        _mass("X_mx", r"m_x'", AddedMass("udot")),
        _mass("X_my", r"m_y'", AddedMass("v r", is_ahead=True)),
        Term(
            "R_0", r"R_0'", hull.resistance, NUMBER, NONNEGATIVE, TermKind.RESISTANCE, SOURCE,
            scale_effect=ScaleEffect.FRICTION,
        ),
        *_polynomial("X", SURGE_POWERS),
        Term("X_thrust", r"1 - t_P", Grouped(mmg.thrust), NUMBER, NONNEGATIVE,
             TermKind.PROPELLER, SOURCE, scale_effect=WAKE),
        _rudder("X_rudder", r"1 - t_R", mmg.rudder_surge),
    ),
    sway=(
        _mass("Y_mass", r"m", hull.rigid_sway),
        _mass("Y_my", r"m_y'", AddedMass("vdot")),
        _mass("Y_mx", r"m_x'", AddedMass("u r")),
        *_polynomial("Y", TURNING_POWERS),
        _rudder("Y_rudder", r"1 + a_H", mmg.rudder_sway),
    ),
    yaw=(
        _mass("N_mass", r"I_z", hull.rigid_yaw),
        _mass("N_jz", r"J_z'", AddedMass("rdot", power=3)),
        *_polynomial("N", TURNING_POWERS, lever=1),
        _rudder("N_rudder", r"-(x_R' + a_H x_H')", mmg.rudder_yaw),
    ),
    ties=(("X_mass", "Y_mass"), ("X_mass", "N_mass"), ("X_mx", "Y_mx"), ("X_my", "Y_my")),
    letters=("X", "Y", "N"),
)  # fmt: skip

# The tables by name; ``speed+keel_gap`` is the table ``speed`` with another form of the bank term.
BASES = {**BARE, "steered": STEERED, "mmg": MMG}
SHORT = {"tapered": "paper+tapered"}  # Other names for some of them


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


TAPERED = table_named("paper+tapered")  # The paper's terms with its boundary-layer taper on the bank
