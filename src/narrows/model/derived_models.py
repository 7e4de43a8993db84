"""Models derived from another: at another scale or depth, with another ship's rudder, with a transverse thrust."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, shown
from narrows.base.named_values import Coefficients
from narrows.base.results import BaseResult
from narrows.model import additions
from narrows.model.data_range import MEASURES, DataRange, extrapolation
from narrows.model.model import Model
from narrows.model.term import DepthLaw, ScaleEffect, TermKind, TermTable
from narrows.model.water import ship_mass
from narrows.quantities.names import GRAVITY, PARTICULARS, Dimension, dimension_of, evaluate
from narrows.ship.checks import is_finite
from narrows.ship.particulars import Canal, Configuration, Water

if TYPE_CHECKING:
    import pandas as pd

# h/T below which the corrections contradict measurements: the drift force by half, for the KCS at 1.2.
SHALLOWEST = 1.5
DEEP = 1e9  # A depth [m] at which every factor is 1
LONGEST = 1e4  # Length greater than any ship's [m]


@dataclass(frozen=True, repr=False)
class DerivedModel(BaseResult):
    """A model made of another."""

    model: Model  #: The new model
    original: Model  #: The model that it was made of
    notes: tuple[str, ...]  #: Effects that are not corrected, and quantities outside the tested range

    def to_dict(self) -> dict[str, Any]:
        old, terms = self.original.coefficients, self.original.terms
        coefficients = {
            name: {"old": old[name], "new": value, "unit": terms[name].dimension.unit}
            for name, value in self.model.coefficients.items()
        }
        return {"coefficients": coefficients, "summary": self.summary(), "notes": list(self.notes)}

    def to_dataframe(self) -> "pd.DataFrame":
        """Return the coefficients as a table: one row each, with old and new value and unit."""
        import pandas as pd

        return pd.DataFrame.from_dict(self.to_dict()["coefficients"], orient="index").rename_axis("coefficient")


class DepthCorrected(DerivedModel):
    """A model corrected for another depth.

    >>> sorted(nw.at_depth(kcs, 15.0).factors)[:1]
    ['N_r']
    """

    @property
    def factors(self) -> dict[str, float]:
        """Factors of the corrected coefficients [1]."""
        return _factors(self.original, self.model.configuration.canal.depth or DEEP)

    def summary(self) -> str:
        configuration = self.model.configuration
        grown = ", ".join(f"{name} times {factor:.3g}" for name, factor in self.factors.items())
        ratio = (configuration.canal.depth or DEEP) / configuration.ship.draft
        return f"Taken to h/T = {ratio:.3g}: {grown or 'nothing was corrected'}."


def _factors(model: Model, depth: float) -> dict[str, float]:
    old, was = model.configuration, model.configuration.canal.depth or DEEP
    laws = {term.name: term.depth_law for term in model.terms.terms if term.depth_law}
    return {name: factor_at(law, old, depth) / factor_at(law, old, was) for name, law in laws.items()}


def factor_at(law: DepthLaw, configuration: Configuration, depth: float) -> float:
    """Return the factor of a coefficient relative to deep water at a depth [1]."""
    return float(evaluate(law.factor, {**configuration.values(), "depth": depth}))


@accept_aliases
def at_depth(model: Model, depth: float) -> DepthCorrected:
    """Correct a model for another depth by Kijima's formulas.

    Tests of unknown depth count as deep. Tests at the depth itself are better: the formulas correct some of the hull's
    coefficients and none of the bank.

    Raises an InputError if no water is left under the keel.

    Parameters
    ----------
    model : Model
        Model for one depth.
    depth : float [m]
        New depth.

    Examples
    --------
    >>> shallower = nw.at_depth(kcs, 15.0)
    >>> shallower.model.canal.depth
    15.0
    """
    old = model.configuration
    if not depth > old.ship.draft:
        raise InputError(f"a depth of {depth} m leaves no water under a draft of {old.ship.draft} m; raise it")
    factors = _factors(model, depth)
    grown = np.array([factors.get(name, 1.0) for name in model.terms.names])
    moved = replace(
        model,
        configuration=replace(old, canal=replace(old.canal, depth=depth)),
        coefficients=Coefficients({name: value * factors.get(name, 1.0) for name, value in model.coefficients.items()}),
        covariance=None if model.covariance is None else model.covariance * np.outer(grown, grown),
        data_range=replace(model.data_range, depth_to_draft=None),
        source=replace(model.source, text=f"{model.source.text}; taken to h/T = {depth / old.ship.draft:.2f} (Kijima)"),
    )
    return DepthCorrected(moved, model, _notes(model, factors, depth))


def _notes(model: Model, factors: Mapping[str, float], depth: float) -> tuple[str, ...]:
    kept = [term.name for term in (*model.terms.sway, *model.terms.yaw) if term.name not in factors]
    unverified = [term.name for term in model.terms.terms if term.depth_law and not term.depth_law.verified]
    deeper = [term.name for term in model.terms.terms if term.needs_depth]
    was, ratio = model.configuration.canal.depth, depth / model.configuration.ship.draft
    found = (
        (kept, f"Not corrected: {', '.join(kept)}."),
        (unverified, f"The exponent for {', '.join(unverified)} is from memory, not verified."),
        (was is None, "The depth of the tests is unknown; they count as deep water."),
        (deeper, f"The terms of {', '.join(deeper)} depend on depth: tests at one depth do not determine them."),
        (ratio < SHALLOWEST, f"h/T = {ratio:.2f} is below {SHALLOWEST}, where the factors grow without limit and none "
         "was measured."),
        (min(factors.values(), default=1.0) < 1 and depth < (was or DEEP),
         "A factor below 1 in shallower water is outside the range of the corrections."),
    )  # fmt: skip
    return tuple(note for applies, note in found if applies)


def extend(
    model: Model, terms: TermTable, coefficients: Mapping[str, float], covariance: np.ndarray | None = None
) -> Model:
    """Return a model with more terms; their errors are independent of the others, and zero unless given."""
    old, new = list(model.terms.names), list(coefficients)
    whole = None
    if model.covariance is not None:
        whole = np.zeros((len(terms), len(terms)))
        for names, part in ((old, model.covariance), (new, 0.0 if covariance is None else covariance)):
            places = [terms.names.index(name) for name in names]
            whole[np.ix_(places, places)] = part
    values = {**model.coefficients, **coefficients}
    return replace(
        model, terms=terms, coefficients=Coefficients({name: values[name] for name in terms.names}), covariance=whole
    )


@accept_aliases
def borrow_rudder(model: Model, lender: Model) -> Model:
    """Return a model with the rudder of another ship.

    The coefficients of a rudder are relative to the area L T/100 and the length. So they hold for a hull with the same
    relative rudder area and the same propeller loading. Their covariance is added if both models have one.

    Raises an InputError if the model has a rudder, or the lender has none.

    Parameters
    ----------
    model : Model
        A model without a rudder.
    lender : Model
        A model with the terms of ``steered``: ``a_helm``, ``b_helm`` and ``c_helm``.
    """
    if any(term.kind == TermKind.RUDDER for term in model.terms.terms):
        raise InputError("the model already has a rudder; leave the other out")
    names = dict(zip(*(additions.HELM.names(one.terms) for one in (model, lender)), strict=True))
    if not set(names.values()) <= set(lender.terms.names):
        raise InputError(
            f"the lender has no {', '.join(names.values())}; give a model fitted with --terms steered, or take a ship "
            "that has a rudder and banks, such as estimated_kcs (narrows ships lists all)"
        )
    ship = replace(model.configuration.ship, flow_straightening=lender.configuration.ship.flow_straightening)
    places = [lender.terms.names.index(lent) for lent in names.values()]
    known = None if lender.covariance is None else lender.covariance[np.ix_(places, places)]
    steered = extend(
        model if known is not None else replace(model, covariance=None),
        additions.HELM(model.terms), {name: lender.coefficients[lent] for name, lent in names.items()}, known,
    )  # fmt: skip
    return replace(
        steered,
        configuration=replace(model.configuration, ship=ship),
        source=replace(model.source, text=f"{model.source.text}; rudder of {lender.configuration.ship.name}"),
    )


@accept_aliases
def with_transverse_thrust(model: Model, share: float = 1.0) -> Model:
    """Return a model whose propeller pushes the stern sideways when it turns astern.

    A right-handed propeller pushes the stern to port, so that the bow turns to starboard. The force is that of the Esso
    Osaka (coefficients A_1 to A_5, B_1 to B_5 of Osaka University's MMG model), relative to L d (n D)^2.

    Raises an InputError if the model has no propeller, or has these terms.

    Parameters
    ----------
    model : Model
        A model with terms of a propeller.
    share : float [1]
        Force relative to the Esso Osaka's; negative for a left-handed propeller.

    Examples
    --------
    >>> tanker = nw.with_transverse_thrust(nw.published("yasukawa2015_kvlcc2_full"))
    >>> nw.crash_stop(tanker, revolutions=-1.0).side_reach > 100
    True
    """
    if not model.terms.propelled:
        raise InputError("the model has no propeller, which could push sideways")
    added = additions.TRANSVERSE_THRUST
    return extend(model, added(model.terms), dict.fromkeys(added.names(model.terms), float(share)))


@dataclass(frozen=True, repr=False)
class Scaled(DerivedModel):
    """A model at another scale, and the effects that do not scale."""

    ratio: float  #: New length over old [1]

    def speed(self, speed: float) -> float:
        """Return the speed at the new scale [m/s] with the Froude number of a ``speed`` [m/s] at the old."""
        return float(speed * self.ratio**0.5)

    def summary(self) -> str:
        return f"Lengths times {self.ratio:.4g}, speeds and times times {self.speed(1.0):.4g} (Froude)."

    def to_dict(self) -> dict[str, Any]:
        ratios = {"ratio": self.ratio, "speed_ratio": self.speed(1.0)}
        return {**ratios, **super().to_dict(), "bis": nondimensional(self.model, "bis")}


@accept_aliases
def scale_model(
    model: Model, length: float, density: float | None = None, width: float | None = None, depth: float | None = None
) -> Scaled:  # fmt: skip
    """Scale a model to another length by Froude's law.

    Masses scale with the cube of the length ratio and with the density, times with the root of the length ratio. A
    scale in the ship's name, as in ``1:52.667``, becomes that of the new ship.

    Raises an InputError if a number is not positive, or the ship does not fit the canal.

    Parameters
    ----------
    model : Model
        The model.
    length : float [m]
        Length between perpendiculars of the new ship.
    density : float [kg/m3], optional
        Density of the new water; unchanged unless given.
    width, depth : float [m], optional
        Dimensions of the new canal; those of the tests at the new scale unless given.
    """
    if not is_finite(length) or not 0 < length < LONGEST:
        raise InputError(f"the length {shown(length)} m of a ship must be over 0 and under {LONGEST:g} m")
    old = model.configuration
    ratio = length / old.ship.length
    water = Water(old.water.density if density is None else density)
    units = Units(ratio**3 * water.density / old.water.density, ratio, ratio**0.5)
    deep = None if old.canal.depth is None else old.canal.depth * ratio
    canal = Canal(old.canal.width * ratio if width is None else width, deep if depth is None else depth)
    particulars = {name: value for name, value in vars(old.ship).items() if name in PARTICULARS and value is not None}
    sizes = {n: v * units.factor(dimension_of(PARTICULARS[n].unit)) for n, v in particulars.items()}
    ship = replace(old.ship, name=name_at_scale(old.ship.name, ratio), **sizes)
    parts = [part.scaled(units.factor) for part in old.parts.values()]
    configuration = Configuration(ship, canal, water).with_parts(parts)
    scales = {name: units.factor(dimension_of(measure.unit)) for name, measure in MEASURES.items()}
    ranges = {n: (pair[0] * scales[n], pair[1] * scales[n]) for n, pair in vars(model.data_range).items() if pair}
    factors = np.array([units.factor(model.terms[name].dimension) for name in model.terms.names])
    coefficients = {n: model.coefficients[n] * f for n, f in zip(model.terms.names, factors.tolist(), strict=True)}
    same = f"The water keeps its density of {water.density:g} kg/m3: the sea's is 1025 (density, --density)."
    place = ((same,) if density is None and ratio > 1 else ()) + _place_notes(model, configuration)
    notes = (*model.bank_notes, *_scale_notes(model), *place)
    scaled = replace(
        model,
        configuration=configuration,
        coefficients=Coefficients(coefficients),
        covariance=None if model.covariance is None else model.covariance * np.outer(factors, factors),
        data_range=DataRange(**ranges),
        source=replace(model.source, text=f"{model.source.text}; scaled by {ratio:.4g} with Froude's law"),
    )
    return Scaled(scaled, model, notes, ratio)


@dataclass(frozen=True)
class Units:
    mass: float  # Unit of mass [kg]
    length: float  # Unit of length [m]
    time: float  # Unit of time [s]

    def factor(self, dimension: Dimension) -> float:
        return float(self.mass**dimension.mass * self.length**dimension.length * self.time**dimension.time)


NOT_SCALED = {
    ScaleEffect.FRICTION: "The friction in {} does not follow Froude's law: a ship has less than this (give its own by "
    "with_coefficients).",
    ScaleEffect.CROSSFLOW_DRAG: "The drag of crossflow in {} depends on the Reynolds number, which differs.",
    ScaleEffect.WAKE: "A ship's wake is thinner than its model's, and its propeller is loaded less; neither is "
    "corrected here.",
    ScaleEffect.BANK_SHAPE: "The coefficients are valid for the bank shape of the tests only.",
}


def _scale_notes(model: Model) -> tuple[str, ...]:
    held = {
        effect: " and ".join(term.name for term in model.terms.terms if term.scale_effect is effect)
        for effect in ScaleEffect
    }
    notes = [words.format(held[effect]) for effect, words in NOT_SCALED.items() if held[effect]]
    if held[ScaleEffect.TEST_SPEED] and (pair := model.data_range.speed):
        notes.append(
            f"{held[ScaleEffect.TEST_SPEED]} hold parts proportional to the speed of the tests, {pair[0]:.3g} to "
            f"{pair[1]:.3g} m/s: far from that speed, scaled, they do not hold."
        )
    return tuple(notes)


def _place_notes(model: Model, configuration: Configuration) -> tuple[str, ...]:
    """Notes on the new canal outside the tested range, in ratios that do not depend on the scale."""
    old, ship, canal = model.configuration, configuration.ship, configuration.canal
    wide, deep = old.canal.width / old.ship.beam, (old.canal.depth or 0.0) / old.ship.draft
    depths = model.data_range.depth_to_draft or ((deep, deep) if deep else None)
    known = DataRange(width_to_beam=(wide, wide), depth_to_draft=depths)
    asked = {"width_to_beam": canal.width / ship.beam}
    if canal.depth is None:
        unknown = "The depth of the water is not given, so h/T and the depth Froude number are not known."
        return (*extrapolation(known, asked), unknown)
    asked["depth_to_draft"] = canal.depth / ship.draft
    notes = [*extrapolation(known, asked, unknown=True)]
    if model.source.estimate and known.outside("depth_to_draft", asked["depth_to_draft"]):
        notes.append(
            f"The hull was estimated for another depth; estimate it anew: narrows estimate --length {ship.length:g} "
            f"--beam {ship.beam:g} --draft {ship.draft:g} --block {ship.block_coefficient:g} --width {canal.width:g} "
            f"--depth {canal.depth:g} -o ship.toml."
        )
    if (pair := model.data_range.speed) and old.canal.depth:
        froude = pair[1] / (GRAVITY * old.canal.depth) ** 0.5
        most = froude * (GRAVITY * canal.depth) ** 0.5
        notes.append(f"Beyond {most:.3g} m/s its depth Froude number leaves the tests', up to {froude:.3g}.")
    return tuple(notes)


# Nondimensional models: every factor comes from the dimension of its term.
System = Literal["prime1", "prime2", "bis"]
SYSTEMS = get_args(System)


def units_of(configuration: Configuration, system: System, speed: float | None = None) -> Units:
    # SNAME (1950), Nomenclature for treating the motion of a submerged body through a fluid; Norrbin (1970) for bis.
    ship, density = configuration.ship, configuration.water.density
    if system not in SYSTEMS:
        raise InputError(f"nondimensional system {system!r} is unknown; choose {', '.join(SYSTEMS)}")
    if system == "bis":
        return Units(ship_mass(configuration), ship.length, float((ship.length / GRAVITY) ** 0.5))
    if not (speed and 0 < speed < float("inf")):
        raise InputError(f"system {system} needs a speed; give a positive one, speed=... in m/s, or system='bis'")
    depth = ship.length if system == "prime1" else ship.draft
    return Units(density / 2 * ship.length**2 * depth, ship.length, ship.length / speed)


@accept_aliases
def nondimensional(model: Model, system: System = "prime2", speed: float | None = None) -> dict[str, float]:
    """Return a model's nondimensional coefficients.

    Raises an InputError if the system is unknown or lacks a speed.

    Parameters
    ----------
    model : Model
        The model.
    system : str
        ``prime1``, ``prime2`` or ``bis``.
    speed : float [m/s], optional
        Speed for the prime systems.
    """
    units = units_of(model.configuration, system, speed)
    return {n: v / units.factor(model.terms[n].dimension) for n, v in model.coefficients.items()}


def name_at_scale(name: str, ratio: float) -> str:
    """Return a ship's name after scaling its lengths; a name without a scale, as ``KCS 1:52.667``, is unchanged."""

    def renamed(known: re.Match[str]) -> str:
        scale = float(known[1] or 1.0) / ratio
        return "at full scale" if abs(scale - 1) < 5e-3 else f"1:{scale:.5g}"

    return re.sub(r"\b1:(\d+(?:\.\d+)?)\b|\bat full scale\b", renamed, name)
