"""Tables derived from others: with a rudder, asymmetry, transverse thrust, with hull coefficients for each depth."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import SimpleNamespace
from typing import Any

from narrows.base.errors import InputError
from narrows.model.term import DEPTH, FREE, NONNEGATIVE, Bound, Term, TermKind, TermTable
from narrows.physics import propeller_and_rudder as mmg
from narrows.physics.hull import HullPower
from narrows.quantities.arithmetic import maximum, minimum
from narrows.quantities.names import NUMBER, Number, name_of


class Asked:
    """Notes the attributes that a function reads, each of which is 1."""

    def __getattr__(self, name: str) -> float:
        setattr(self, name, 1.0)
        return 1.0


@dataclass(frozen=True)
class Grouped:
    """A regressor from a function of one object, whose attributes are names of the vocabulary."""

    function: Callable[[Any], Number]

    @cached_property
    def inputs(self) -> tuple[str, ...]:
        asked = Asked()
        self.function(asked)
        return tuple(vars(asked))

    @property
    def name(self) -> str:
        return name_of(self.function)

    def __call__(self, *values: Number) -> Number:
        return self.function(SimpleNamespace(**dict(zip(self.inputs, values, strict=True))))


@dataclass(frozen=True)
class Addition:
    """A term more in some forces of any table."""

    word: str  # Suffix of the name of a table with them; none if another one stands for them
    what: str  # What they are, in a sentence
    ending: str  # Ending of the names of the coefficients
    subscript: str  # The same in the symbols
    laws: Mapping[str, Callable[..., Number]]  # Regressors of ``surge``, ``sway`` and ``yaw``
    kind: TermKind
    source: str
    bound: Bound = FREE
    is_alone: bool = False  # True if a table may have no other terms of its kind

    def terms(self, table: TermTable) -> dict[str, Term]:
        """Return the terms by force, with a table's names."""
        letters = dict(zip(("surge", "sway", "yaw"), table.letters, strict=True))
        return {
            force: Term(f"{letters[force]}_{self.ending}", f"{letters[force]}_{self.subscript}", law, NUMBER,
                        self.bound, self.kind, self.source)
            for force, law in self.laws.items()
        }  # fmt: skip

    def names(self, table: TermTable) -> tuple[str, ...]:
        return tuple(term.name for term in self.terms(table).values())

    def __call__(self, table: TermTable, name: str = "") -> TermTable:
        kinds = {term.kind for term in table.terms} if self.is_alone else set()
        if self.kind in kinds or {*self.names(table)} & {*table.names}:
            raise InputError(f"the terms {table.name!r} have {self.what}; leave +{self.word} out")
        added = {force: [term] for force, term in self.terms(table).items()}
        return table.with_terms(name or f"{table.name}+{self.word}".removesuffix("+"), **added)


HELM = Addition(
    "helm", "a rudder", "helm", "{helm}",
    {"surge": Grouped(mmg.helm_surge), "sway": Grouped(mmg.helm_sway), "yaw": Grouped(mmg.helm_yaw)},
    TermKind.RUDDER, "form of Yasukawa and Yoshimura (2015)", NONNEGATIVE, is_alone=True,
)  # fmt: skip

# A constant force and moment, proportional to the speed squared.
ASYMMETRY = Addition(
    "asymmetry", "an asymmetry", "0", "0'", {"sway": HullPower(0, 0), "yaw": HullPower(0, 0, lever=1)}, TermKind.HULL,
    "Y_0' and N_0' of polynomial manoeuvring models, as in Abkowitz (1964)",
)  # fmt: skip

STRAIGHTENED = "rudder_straightening_port"  # Input of the rudder of the MMG standard method
STRAIGHTENING = Addition(
    "", "a flow straightening by side", "straightening", r"{\gamma}'",
    {"sway": Grouped(mmg.straightening_sway), "yaw": Grouped(mmg.straightening_yaw)},
    TermKind.RUDDER, "gamma_R by side of Yasukawa and Yoshimura (2015)",
)  # fmt: skip
RUDDER_EVEN = Addition(
    "", "a rudder that is stronger to one side", "rudder_even", r"{\delta\delta}'",
    {"sway": Grouped(mmg.even_rudder_sway), "yaw": Grouped(mmg.even_rudder_yaw)},
    TermKind.RUDDER, "Y_deltadelta and N_deltadelta of polynomial manoeuvring models, as in Abkowitz (1964)",
)  # fmt: skip


def asymmetric(table: TermTable) -> TermTable:
    """Return a table with an asymmetry; in the slipstream of a propeller also with those of the rudder."""
    added = ASYMMETRY(table)
    return RUDDER_EVEN(STRAIGHTENING(added)) if STRAIGHTENED in table.inputs else added


# The push of a propeller that turns astern, relative to the Esso Osaka's.
TRANSVERSE_THRUST = Addition(
    "transverse_thrust", "a transverse thrust", "astern", "{astern}",
    {"sway": Grouped(mmg.transverse_thrust), "yaw": Grouped(mmg.transverse_thrust_yaw)},
    TermKind.PROPELLER, "MMG model of the Esso Osaka astern, Osaka University",
)  # fmt: skip

# Additions to a table besides a form of the bank.
ADDED: dict[str, Callable[[TermTable], TermTable]] = {
    "helm": HELM, ASYMMETRY.word: asymmetric, TRANSVERSE_THRUST.word: TRANSVERSE_THRUST,
}  # fmt: skip

AT = "@"  # Separator between a name and a depth in metres: ``b_v@0.41``, ``paper@0.246,0.41``


def pooled(table: TermTable, depths: Sequence[float]) -> TermTable:
    """Return a table with one coefficient per depth for each hull term."""
    # Between depths a coefficient is linear, beyond them constant. Terms of the bank are unchanged: shared, or with
    # their own dependence on depth.
    knots = sorted(set(depths))
    if len(knots) < 2 or not knots[0] > 0:
        raise InputError(f"hulls of their own at each depth need two depths or more; there are {len(knots)}")

    hull = {term.name for term in table.terms if not term.from_bank}
    ties = tuple((_named(a, h), _named(b, h)) for a, b in table.ties if {a, b} <= hull for h in knots)
    name = f"{table.name}{AT}{','.join(f'{h:g}' for h in knots)}"
    surge, sway, yaw = (
        tuple(each for term in part for each in ([term] if term.from_bank else _at_each(term, knots)))
        for part in table.forces.values()
    )
    return replace(table, name=name, ties=ties, surge=surge, sway=sway, yaw=yaw)


def _named(name: str, depth: float) -> str:
    return f"{name}{AT}{depth:g}"


def _at_each(term: Term, knots: list[float]) -> list[Term]:
    return [
        replace(
            term, name=_named(term.name, h), symbol=f"{term.symbol}^{{{h:g}\\,m}}", regressor=_near(term, knots, i),
            depth_law=None,
        )
        for i, h in enumerate(knots)
    ]  # fmt: skip


def _near(term: Term, knots: list[float], i: int) -> Callable[..., Number]:
    """The regressor times a hat function of depth: 1 at its knot, 0 at the neighbours."""
    asks = tuple(dict.fromkeys((*term.inputs, DEPTH)))

    def regressor(*values: Number) -> Number:
        at = dict(zip(asks, values, strict=True))
        return term.column(at) * _share(at[DEPTH], knots, i)

    regressor.inputs = asks  # type: ignore[attr-defined]
    return regressor


def _share(depth: Number, knots: list[float], i: int) -> Number:
    rising = (depth - knots[i - 1]) / (knots[i] - knots[i - 1]) if i else 1.0
    falling = (knots[i + 1] - depth) / (knots[i + 1] - knots[i]) if i + 1 < len(knots) else 1.0
    return maximum(minimum(minimum(rising, falling), 1.0), 0.0)
