"""A model as one table of terms: the source of columns, constraints, ties, dimensions and equations."""

import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property
from keyword import iskeyword
from typing import TYPE_CHECKING

from narrows.base.errors import InputError, check_choice, did_you_mean, shown
from narrows.base.named_values import by_name
from narrows.base.results import BaseSummary
from narrows.physics import squat_and_depth
from narrows.quantities.names import FORCES, REGRESSOR_INPUTS, Dimension, Number, Quantity, argument_names
from narrows.ship.actuators import PROPELLER, STANDARD, Actuator, with_standard
from narrows.ship.checks import is_finite

if TYPE_CHECKING:
    import pandas as pd

Bound = tuple[float, float]
FREE: Bound = (float("-inf"), float("inf"))
NONNEGATIVE: Bound = (0.0, float("inf"))
BANKS, DEPTH = "width", "depth"  # Quantities that describe the banks and the water depth

ARITHMETIC = "arithmetic, abs() and minimum, maximum, clip and choice of narrows.quantities.arithmetic"

# Replacements for functions in a regressor, by name.
INSTEAD = {
    "sin cos tan": "sin_psi and cos_psi (quantities, as y and u are) for sine and cosine of the heading, and "
    "-v / (u**2 + v**2) ** 0.5 for the sine of the drift angle",
    "sqrt hypot": "x ** 0.5 for a root",
    "exp": "math.e ** x for an exponential",
    "fabs absolute": "abs(x) for a size",
    "sign copysign": "choice(x, 1.0, -1.0) for a sign",
    "min max minimum maximum clip where heaviside": "minimum(x, y), maximum(x, y) or clip(x, most)",
    "pow power square": "x ** 2 for a power",
}

LETTERS = ("a", "b", "c")  # First letters of the paper's coefficients, by force


class TermKind(StrEnum):
    """Kind of a term.

    >>> nw.PAPER["b_bank"].kind.name
    'BANK'
    """

    INERTIA = "inertia"
    RESISTANCE = "resistance"
    DAMPING = "damping"
    LIFT = "lift"
    CROSSFLOW = "crossflow"
    HULL = "hull polynomial"
    BANK = "bank"
    RUDDER = "rudder"
    PROPELLER = "propeller"
    THRUSTER = "thruster"
    OTHER = "other"


class ScaleEffect(StrEnum):
    """Effect by which a coefficient deviates from Froude's law."""

    FRICTION = "friction"
    CROSSFLOW_DRAG = "drag of crossflow"
    TEST_SPEED = "speed of the tests"
    WAKE = "wake at the propeller"
    BANK_SHAPE = "shape of the banks"


@dataclass(frozen=True)
class DepthLaw:
    """Growth of a coefficient relative to deep water."""

    factor: Callable[..., Number]  # Function of names of the ship's particulars and ``depth``; 1 in deep water
    verified: bool = True  # True if it was read in its source


@dataclass(frozen=True, repr=False)
class Term(BaseSummary):
    """One coefficient of a model and the regressor that it multiplies.

    Raises an InputError if the name is invalid, or the regressor uses a quantity outside the vocabulary, or the canal's
    width although its kind is not ``bank``.

    >>> nw.PAPER["b_v"].dimension.unit
    'kg/s'
    """

    name: str  #: Name of the coefficient, as in ``b_vdot``
    symbol: str  #: The coefficient in LaTeX
    #: A function of arithmetic, ``abs()`` and the functions of ``quantities.arithmetic``; its arguments are names of
    #: the vocabulary and define the inputs of the term. A composed one lists them in an attribute ``inputs``, in the
    #: order of its arguments.
    regressor: Callable[..., Number]
    dimension: Dimension  #: Dimension of the coefficient
    bound: Bound = FREE  #: Lowest and highest value of the coefficient, in its own unit
    kind: TermKind = TermKind.OTHER  #: Kind of the term
    source: str = ""  #: Source of the term
    depth_law: DepthLaw | None = None  #: Growth of the coefficient relative to deep water, if known
    scale_effect: ScaleEffect | None = None  #: Effect by which the coefficient deviates from Froude's law
    #: The user's own actuator, whose quantities the regressor uses besides those of the vocabulary
    actuator: Actuator | None = None

    def __post_init__(self) -> None:
        taken = {*self._vocabulary, *(actuator.name for actuator in self._known)}
        # No blanks, and no two underscores at its start
        if not re.fullmatch(r"(?!__)\S+", self.name) or iskeyword(self.name) or self.name in taken:
            raise InputError(f"a coefficient cannot be called {shown(self.name)}; give it a name such as b_vv")
        for word in self.inputs:
            if word not in self._vocabulary:
                hint = did_you_mean(word, self._vocabulary)
                raise InputError(f"term {self.name}: its regressor needs an unknown {word!r}{hint}")
        if BANKS in self.inputs and not self.from_bank:
            raise InputError(f"term {self.name}: it needs the canal's {BANKS}; give it kind=TermKind.BANK")

    def summary(self) -> str:
        return f"{self.name} [{self.dimension.unit}], {self.kind.value}, of {', '.join(self.inputs)}"

    @cached_property
    def inputs(self) -> tuple[str, ...]:
        """Inputs of the regressor."""
        return argument_names(self.regressor)

    @property
    def _known(self) -> tuple[Actuator, ...]:
        return STANDARD if self.actuator is None else with_standard([self.actuator])

    @property
    def _vocabulary(self) -> dict[str, Quantity]:
        return REGRESSOR_INPUTS | {word: of for one in self._known for word, of in one.quantities.items()}

    @cached_property
    def quantities(self) -> dict[str, Quantity]:
        """Unit and meaning of the regressor's inputs."""
        return {word: self._vocabulary[word] for word in self.inputs}

    @cached_property
    def actuators(self) -> tuple[Actuator, ...]:
        """Actuators whose quantities the regressor uses."""
        return tuple(one for one in self._known if not set(self.inputs).isdisjoint(one.quantities))

    @property
    def from_bank(self) -> bool:
        """True for a term of the banks."""
        return self.kind == TermKind.BANK

    @property
    def needs_depth(self) -> bool:
        """True if it uses the water depth."""
        return DEPTH in self.inputs

    def column(self, values: Mapping[str, Number]) -> Number:
        """Evaluate the regressor from ``values`` of the quantities by name; further ones are ignored."""
        return self.regressor(*[values[name] for name in self.inputs])


@dataclass(frozen=True, repr=False)
class TermTable(BaseSummary):
    """The terms of surge force, sway force and yaw moment, and which coefficients are equal.

    Raises an InputError if there are no terms, two terms or two actuators share a name, a term has the name of a force,
    or a tie names no term.

    >>> len(nw.PAPER.names)
    17
    """

    name: str  #: Name of the table in model files
    surge: tuple[Term, ...]  #: Terms of the surge force [N]
    sway: tuple[Term, ...]  #: Terms of the sway force [N]
    yaw: tuple[Term, ...]  #: Terms of the yaw moment [N m]
    ties: tuple[tuple[str, str], ...] = ()  #: Coefficients held equal
    letters: tuple[str, str, str] = LETTERS  #: First letters of the coefficients in X, Y and N

    def __post_init__(self) -> None:
        names = self.names
        if not names:
            raise InputError(f"table {self.name}: it has no terms; give it one")
        for name in names:
            if name in FORCES:
                raise InputError(f"table {self.name}: {name!r} is a force; call the coefficient otherwise")
        by_name(f"terms of table {self.name}", ((name, name) for name in names))
        with_standard(self.actuators)
        for name in (name for tie in self.ties for name in tie):
            if name not in names:
                raise InputError(f"table {self.name}: a tie names {name!r}{did_you_mean(name, names)}")

    def summary(self) -> str:
        counts = ", ".join(f"{len(terms)} of {force}" for force, terms in self.forces.items())
        return f"The terms {self.name}: {counts}; they need {', '.join(self.inputs)}."

    def to_dataframe(self) -> "pd.DataFrame":
        """Return the terms as a table: one row each, with force, kind, unit, bounds, inputs and source."""
        import pandas as pd

        rows = [
            (term.name, force, term.kind.value, term.dimension.unit, *term.bound, ", ".join(term.inputs), term.source)
            for force, terms in self.forces.items() for term in terms
        ]  # fmt: skip
        columns = ["coefficient", "force", "kind", "unit", "lowest", "highest", "inputs", "source"]
        return pd.DataFrame(rows, columns=columns).set_index("coefficient")

    def __len__(self) -> int:
        return len(self.names)

    @cached_property
    def forces(self) -> dict[str, tuple[Term, ...]]:
        """The terms by force."""
        return dict(zip(FORCES, (self.surge, self.sway, self.yaw), strict=True))

    @property
    def terms(self) -> tuple[Term, ...]:
        """Every term, surge first."""
        return (*self.surge, *self.sway, *self.yaw)

    @property
    def names(self) -> tuple[str, ...]:
        """Every coefficient's name, surge first."""
        return tuple(term.name for term in self.terms)

    @property
    def inputs(self) -> tuple[str, ...]:
        """Inputs of all terms."""
        return tuple(dict.fromkeys(word for term in self.terms for word in term.inputs))

    @cached_property
    def quantities(self) -> dict[str, Quantity]:
        """Unit and meaning of the inputs of all terms, in the order of the vocabulary."""
        asked = {word: quantity for term in self.terms for word, quantity in term.quantities.items()}
        movers = [word for actuator in self.actuators for word in actuator.quantities]
        return {word: asked[word] for word in (*REGRESSOR_INPUTS, *movers) if word in asked}

    @cached_property
    def actuators(self) -> tuple[Actuator, ...]:
        """Actuators of the terms: those of the package first, then others in the order of the terms."""
        asked = dict.fromkeys(actuator for term in self.terms for actuator in term.actuators)
        return (
            *(actuator for actuator in STANDARD if actuator in asked),
            *(actuator for actuator in asked if actuator not in STANDARD),
        )

    @property
    def propelled(self) -> bool:
        """True if a term uses the propeller."""
        return PROPELLER in self.actuators

    @property
    def has_bank(self) -> bool:
        """True if a term is of the banks."""
        return any(term.from_bank for term in self.terms)

    @property
    def bank_note(self) -> str:
        """Note for questions about a canal if no term is of the bank; nothing otherwise."""
        sentence = f"The terms {self.name!r} have no bank force: a bank only ends a voyage"
        return "" if self.has_bank else f"{sentence}; a name like mmg+delta adds one."

    @property
    def needs_depth(self) -> bool:
        """True if a term uses the water depth."""
        return any(term.needs_depth for term in self.terms)

    def __getitem__(self, name: str) -> Term:
        """The term of a coefficient."""
        for term in self.terms:
            if term.name == name:
                return term
        raise KeyError(name)

    def with_terms(
        self, name: str, surge: Iterable[Term] = (), sway: Iterable[Term] = (), yaw: Iterable[Term] = ()
    ) -> "TermTable":
        """Return the table, called ``name``, with terms added to ``surge``, ``sway`` and ``yaw``, or replaced if the
        name exists.
        """
        pairs = (*self.surge, *surge), (*self.sway, *sway), (*self.yaw, *yaw)
        of_x, of_y, of_n = (tuple({one.name: one for one in terms}.values()) for terms in pairs)
        return replace(self, name=name, surge=of_x, sway=of_y, yaw=of_n)

    def with_fixed(self, values: Mapping[str, float]) -> "TermTable":
        """Return the table with some coefficients at ``values``, which a fit keeps; an InputError for another name."""
        if not isinstance(values, Mapping):
            raise InputError(f"fixed = {shown(values)} has no values by name; give them, as in {{'b_bank': 0.0}}")
        for name, value in values.items():
            if not is_finite(value):
                raise InputError(f"fixed: {name} = {shown(value)} is no finite number; give its value")
        return self.with_bounds({name: (value, value) for name, value in values.items()}, "fixed")

    def with_bounds(self, bounds: Mapping[str, tuple[float, float]], argument: str = "bounds") -> "TermTable":
        """Return the table with other ``bounds`` of some coefficients; an InputError for another name, or no bounds.

        The ``argument`` names them in messages.
        """
        if not isinstance(bounds, Mapping):
            raise InputError(f"bounds = {shown(bounds)} are not by name; give them, as in {{'b_vdot': (0.0, None)}}")
        changed = {}
        for name, ends in bounds.items():
            check_choice(argument, name, self.names)
            try:
                low, high = ends
                bound = -math.inf if low is None else float(low), math.inf if high is None else float(high)
            except (TypeError, ValueError):
                bound = math.nan, math.nan
            if not bound[0] <= bound[1]:
                raise InputError(f"{argument}: {name} = {shown(ends)} is no lower and upper bound; give both")
            changed[name] = replace(self[name], bound=bound)
        surge, sway, yaw = (tuple(changed.get(one.name, one) for one in terms) for terms in self.forces.values())
        return replace(self, surge=surge, sway=sway, yaw=yaw)


def without(table: TermTable, name: str, leave: Callable[[Term], bool]) -> TermTable:
    """Return a table without some terms and their ties."""
    surge, sway, yaw = (tuple(term for term in terms if not leave(term)) for terms in table.forces.values())
    kept = {term.name for term in (*surge, *sway, *yaw)}
    ties = tuple(tie for tie in table.ties if set(tie) <= kept)
    return replace(table, name=name, surge=surge, sway=sway, yaw=yaw, ties=ties)


def uncompiled(term: Term, error: Exception) -> InputError:
    """Return the message for a regressor beyond arithmetic: what to write instead."""
    used = getattr(getattr(term.regressor, "__code__", None), "co_names", ())
    instead = [remedy for words, remedy in INSTEAD.items() if set(words.split()) & set(used)]
    if "compares" in str(error) or "branches" in str(error) or "ambiguous" in str(error):
        instead.append("choice(v, a, b) for a where v is over 0 and b elsewhere, instead of an if")
    remedy = f": {'; '.join(instead)}" * bool(instead)
    why = str(error).partition("\n")[0].rstrip(".")
    sentence = f"term {term.name}: its regressor cannot be compiled ({why}); write it with {ARITHMETIC}"
    return InputError(sentence + remedy)


DRIFT_FORCE = DepthLaw(squat_and_depth.kijima_drift_force)
DRIFT_MOMENT = DepthLaw(squat_and_depth.kijima_drift_moment, verified=False)
YAW_MOMENT = DepthLaw(squat_and_depth.kijima_yaw_moment)
