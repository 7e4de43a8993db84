"""Models at another scale by Froude's law, and the effects that do not scale."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import log10
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, shown
from narrows.base.results import BaseResult, Named
from narrows.model.data_range import MEASURES, DataRange
from narrows.model.model import Model
from narrows.model.term import ScaleEffect
from narrows.model.water import ship_mass
from narrows.quantities.dimensions import Dimension, dimension_of
from narrows.quantities.names import GRAVITY, PARTICULARS
from narrows.ship.checks import is_finite
from narrows.ship.motion import Motion
from narrows.ship.particulars import Canal, Configuration, Water

if TYPE_CHECKING:
    import pandas as pd

# Length greater than any ship's [m].
LONGEST = 1e4


@dataclass(frozen=True, repr=False)
class Scaled(BaseResult):
    """A model at another scale, and the effects that do not scale.

    Parameters
    ----------
    model : Model
        The model at the new scale.
    original : Model
        The model at the original scale.
    ratio : float [1]
        New length over old.
    notes : tuple of str
        Effects that do not scale, and quantities outside the tested range in the new water.
    """

    model: Model
    original: Model
    ratio: float
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        return f"<Scaled model of {self.model.configuration.ship.name or 'a ship'}: {self.summary()}>"

    def speed(self, speed: float) -> float:
        """Return the speed at the new scale with the Froude number of one at the old [m/s].

        Parameters
        ----------
        speed : float [m/s]
            Speed at the old scale.
        """
        return float(speed * self.ratio**0.5)

    def summary(self) -> str:
        return f"Lengths times {self.ratio:.4g}, speeds and times times {self.speed(1.0):.4g} (Froude)."

    def to_dict(self) -> dict[str, Any]:
        old, terms = self.original.coefficients, self.original.terms
        return {
            "ratio": self.ratio,
            "speed_ratio": self.speed(1.0),
            "coefficients": {
                name: {"old": old[name], "new": value, "unit": terms[name].dimension.unit}
                for name, value in self.model.coefficients.items()
            },
            "bis": nondimensional(self.model, "bis"),
            "summary": self.summary(),
            "notes": list(self.notes),
        }

    def to_dataframe(self) -> "pd.DataFrame":
        """Return the coefficients as a table: one row each, with old and new value and unit."""
        import pandas as pd

        return pd.DataFrame.from_dict(self.to_dict()["coefficients"], orient="index").rename_axis("coefficient")


@dataclass(frozen=True)
class Friction:
    """Data for scaling the friction of a hull by the line of the ITTC.

    Raises an InputError if a number is not positive, or the form factor is negative.

    Parameters
    ----------
    wetted_surface : float [m2]
        Area of the hull at the old scale.
    form_factor : float [1]
        Form factor k.
    speed : float [m/s]
        Speed at the old scale at which the line is evaluated.
    viscosity : pair of float [m2/s]
        Kinematic viscosity of the water at the old scale and at the new.
    """

    wetted_surface: float
    form_factor: float
    speed: float
    viscosity: tuple[float, float] = (1.14e-6, 1.19e-6)

    def __post_init__(self) -> None:
        if not (self.wetted_surface > 0 and self.speed > 0 and min(self.viscosity) > 0 and self.form_factor >= 0):
            raise InputError("friction needs a positive wetted surface, speed and viscosity, and a form factor from 0")


def ittc57(reynolds: float) -> float:
    """Return the frictional resistance coefficient of the ITTC's line [1], 0.075/(log10 Re - 2)^2."""
    # ITTC (1957), Report of the 8th conference: model-ship correlation line.
    if not reynolds >= 1e5:
        raise InputError(f"a Reynolds number of {reynolds:g} is below the range of the ITTC's line; check the speed")
    return 0.075 / (log10(reynolds) - 2) ** 2


@accept_aliases
def scale_model(
    model: Model, length: float, density: float | None = None, width: float | None = None, depth: float | None = None,
    friction: Friction | None = None,
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
    friction : Friction, optional
        Scale the friction in the resistance by the line of the ITTC instead of by Froude's law.
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
    notes = (*model.bank_notes, *_scale_notes(model, friction), *place)
    if friction:
        coefficients |= _with_friction(model, friction, configuration, coefficients)
    scaled = replace(
        model,
        configuration=configuration,
        coefficients=Named(coefficients),
        covariance=None if model.covariance is None else model.covariance * np.outer(factors, factors),
        data_range=DataRange(**ranges),
        source=replace(model.source, text=f"{model.source.text}; scaled by {ratio:.4g} with Froude's law"),
    )
    return Scaled(scaled, model, ratio, notes)


@dataclass(frozen=True)
class Units:
    mass: float  # Unit of mass [kg]
    length: float  # Unit of length [m]
    time: float  # Unit of time [s]

    def factor(self, dimension: Dimension) -> float:
        return float(self.mass**dimension.mass * self.length**dimension.length * self.time**dimension.time)


def _with_friction(
    model: Model, friction: Friction, configuration: Configuration, scaled: Mapping[str, float]
) -> dict[str, float]:
    """The resistance with the friction of the old scale replaced by that of the new."""
    terms = _holding(model, ScaleEffect.FRICTION)
    if not terms:
        raise InputError("the model has no resistance to scale the friction of; leave the form factor out")
    name = terms[0]
    small, large = (
        # Resistance by the line and per unit of the coefficient, over the square of the speed
        _line(friction, setting, nu, model.configuration)
        / -float(model.terms[name].column({**setting.values(), **Motion.at(u=1.0).values()}))
        for setting, nu in zip((model.configuration, configuration), friction.viscosity, strict=True)
    )
    whole = model.coefficients[name]
    if small > whole > 0:
        raise InputError(
            f"the friction is more than the whole of {name}; check the wetted surface, form factor and speed"
        )
    share = scaled[name] / whole if whole else 1.0
    return {name: max((whole - small) * share + large, 0.0)}


def _line(friction: Friction, setting: Configuration, viscosity: float, old: Configuration) -> float:
    """Frictional resistance over the square of the speed, by the line, for the hull at that length [kg/m]."""
    ratio, length = setting.ship.length / old.ship.length, setting.ship.length
    coefficient = (1 + friction.form_factor) * ittc57(friction.speed * ratio**0.5 * length / viscosity)
    return 0.5 * setting.water.density * friction.wetted_surface * ratio**2 * coefficient


def _holding(model: Model, effect: ScaleEffect) -> list[str]:
    return [term.name for term in model.terms.terms if term.scale_effect is effect]


def _scale_notes(model: Model, friction: Friction | None) -> tuple[str, ...]:
    notes = []
    if (resisting := _holding(model, ScaleEffect.FRICTION)) and not friction:
        notes.append(
            f"The friction in {resisting[0]} does not follow Froude's law: a ship has less than this "
            "(give a form factor)."
        )
    if drags := _holding(model, ScaleEffect.CROSSFLOW_DRAG):
        notes.append(f"The drag of crossflow in {' and '.join(drags)} depends on the Reynolds number, which differs.")
    if _holding(model, ScaleEffect.WAKE):
        notes.append(
            "A ship's wake is thinner than its model's, and its propeller is loaded less; neither is corrected here."
        )
    if (held := _holding(model, ScaleEffect.TEST_SPEED)) and (pair := model.data_range.speed):
        notes.append(
            f"{', '.join(held)} hold parts proportional to the speed of the tests, {pair[0]:.3g} to {pair[1]:.3g} m/s: "
            "far from that speed, scaled, they do not hold."
        )
    if _holding(model, ScaleEffect.BANK_SHAPE):
        notes.append("The coefficients are valid for the bank shape of the tests only.")
    return tuple(notes)


def _place_notes(model: Model, configuration: Configuration) -> tuple[str, ...]:
    """Notes on the new canal outside the tested range, in ratios that do not depend on the scale."""
    notes = []
    old, ship = model.configuration, configuration.ship
    wide, was = configuration.canal.width / ship.beam, old.canal.width / old.ship.beam
    if DataRange(width_to_beam=(was, was)).outside("width_to_beam", wide):
        notes.append(f"W/B = {wide:.2f} is not that of the tests, {was:.2f}.")
    if configuration.canal.depth is None:
        return (*notes, "The depth of the water is not given, so h/T and the depth Froude number are not known.")
    covered = model.data_range.depth_to_draft or (old.canal.depth and (old.canal.depth / old.ship.draft,) * 2)
    ratio = configuration.canal.depth / ship.draft
    if not covered:
        notes.append(f"h/T = {ratio:.2f}, and the tests' is not known.")
    elif DataRange(depth_to_draft=covered).outside("depth_to_draft", ratio):
        span = f"{covered[0]:.2f} to {covered[1]:.2f}"
        outside = f"tests' {span}"
        if model.source.estimate:
            outside = (
                f"{span} that the hull was estimated for; estimate it anew: narrows estimate --length {ship.length:g} "
                f"--beam {ship.beam:g} --draft {ship.draft:g} --block {ship.block_coefficient:g} --width "
                f"{configuration.canal.width:g} --depth {configuration.canal.depth:g} -o ship.toml"
            )
        notes.append(f"h/T = {ratio:.2f} is outside the {outside}.")
    if (pair := model.data_range.speed) and old.canal.depth:
        froude = pair[1] / (GRAVITY * old.canal.depth) ** 0.5
        most = froude * (GRAVITY * configuration.canal.depth) ** 0.5
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


def dimensional(
    numbers: Mapping[str, float], model: Model, system: System = "prime2", speed: float | None = None
) -> Model:
    """Return a model from nondimensional coefficients.

    Raises an InputError if the system is unknown, lacks a speed, or a coefficient is missing or unknown.

    Parameters
    ----------
    numbers : mapping of str to float [1]
        The coefficients.
    model : Model
        Model with the ship, the terms and all else; its own coefficients are replaced.
    system : str
        ``prime1``, ``prime2`` or ``bis``.
    speed : float [m/s], optional
        Speed for the prime systems.
    """
    units = units_of(model.configuration, system, speed)
    known = {n: v * units.factor(model.terms[n].dimension) for n, v in numbers.items() if n in model.terms.names}
    return replace(model, coefficients=Named({**numbers, **known}), covariance=None)


# Scale in a ship's name, as in ``KCS 1:52.667``, valid for every size of the ship.
SCALE = re.compile(r"\b1:(?P<smaller>\d+(\.\d+)?)\b|\b(?P<larger>\d+(\.\d+)?):1\b|\bat full scale\b")


def name_at_scale(name: str, ratio: float) -> str:
    """Return a ship's name after scaling its lengths; a name without a scale stays unchanged."""

    def renamed(known: re.Match[str]) -> str:
        scale = float(known["smaller"] or 1.0) / float(known["larger"] or 1.0) / ratio
        if abs(scale - 1) < 5e-3:
            return "at full scale"
        return f"1:{scale:.5g}" if scale > 1 else f"{1 / scale:.4g}:1"

    return SCALE.sub(renamed, name)
