"""Every quantity of physics, tables and files: one name, one unit, one meaning; units and dimensions."""

import inspect
import math
import re
from collections.abc import Callable, Mapping
from functools import cache, lru_cache
from types import FunctionType
from typing import Any, NamedTuple

from narrows.base.errors import InputError

# A float, a NumPy array or a symbol: any type with arithmetic and ``abs()``.
Number = Any


class Quantity(NamedTuple):
    unit: str  # SI unit
    meaning: str  # Meaning in words


MOTION = {
    "x": Quantity("m", "midship along the canal"),
    "y": Quantity("m", "midship to starboard of the centreline"),
    "cos_psi": Quantity("1", "cosine of the heading"),
    "sin_psi": Quantity("1", "sine of the heading, positive clockwise seen from above"),
    "u": Quantity("m/s", "surge velocity through the water"),
    "v": Quantity("m/s", "sway velocity through the water"),
    "r": Quantity("rad/s", "yaw rate"),
    "udot": Quantity("m/s2", "surge acceleration in the ship's axes"),
    "vdot": Quantity("m/s2", "sway acceleration in the ship's axes"),
    "rdot": Quantity("rad/s2", "yaw acceleration"),
    "heave": Quantity("m", "midship sinkage z, positive down"),
}

PARTICULARS = {
    "length": Quantity("m", "length between perpendiculars L"),
    "beam": Quantity("m", "beam B"),
    "draft": Quantity("m", "draft at rest T0"),
    "block_coefficient": Quantity("1", "displaced volume over L B T0, C_B"),
    "mass": Quantity("kg", "displacement m"),
    "inertia": Quantity("kg m2", "yaw moment of inertia about midship I_z"),
    "x_g": Quantity("m", "centre of gravity forward of midship"),
    "flow_straightening": Quantity(
        "1", "flow across the rudder over that across the stern, over its flow along, gamma_R"
    ),
    "width": Quantity("m", "canal width W"),
    "depth": Quantity("m", "water depth h"),
    "density": Quantity("kg/m3", "mass density of the water rho"),
}

FORCES = {
    "X": Quantity("N", "surge force, positive forward"),
    "Y": Quantity("N", "sway force, positive to starboard"),
    "N": Quantity("N m", "yaw moment about midship, positive bow to starboard"),
}

# Acceleration along each force.
ACCELERATIONS = dict(zip(FORCES, ("udot", "vdot", "rdot"), strict=True))

# Possible inputs of any term; actuators add their own.
REGRESSOR_INPUTS = MOTION | PARTICULARS


def argument_names(function: Callable[..., Number]) -> tuple[str, ...]:
    stated: tuple[str, ...] | None = getattr(function, "inputs", None)
    if stated is not None:
        return stated
    return _parameters(function) if isinstance(function, FunctionType) else _parameters.__wrapped__(function)


@lru_cache(maxsize=1024)
def _parameters(function: Callable[..., Number]) -> tuple[str, ...]:
    return tuple(inspect.signature(function).parameters)


def evaluate(function: Callable[..., Number], values: Mapping[str, Number]) -> Number:
    """Call a function of quantities with their values by name; further ones are ignored."""
    return function(*[values[name] for name in argument_names(function)])


def name_of(function: Callable[..., Number]) -> str:
    return str(getattr(function, "name", "") or getattr(function, "__name__", type(function).__name__))


# Constants of nature and of units. Gravity of the earth [m/s2].
GRAVITY = 9.81

# One nautical mile an hour [m/s].
KNOT = 1852 / 3600
DEGREE = math.pi / 180  # [rad]
# Units of a written speed [m/s].
SPEED_UNITS = {
    "": 1.0, "m/s": 1.0, "mps": 1.0, **dict.fromkeys(("kn", "kt", "kts", "knot", "knots"), KNOT),
    **dict.fromkeys(("km/h", "kmh", "kph"), 1 / 3.6),
}  # fmt: skip

# Units at the end of a name, such as ``speed_knots`` and ``psi_deg``, by the first pattern that it matches [SI].
NAME_UNITS = {
    r"(?:.*_)?(?:u|v|speeds?|current)": {unit.replace("/", ""): size for unit, size in SPEED_UNITS.items() if unit},
    r"(?:.*_)?(?:psi|heading|rudder)": {"deg": DEGREE, "rad": 1.0},
    r"(?:.*_)?r": {"deg": DEGREE, "degs": DEGREE, "degmin": DEGREE / 60, "rad": 1.0, "rads": 1.0},
    "revolutions": {"rpm": 1 / 60, "rps": 1.0},
    "duration|dt": {"s": 1.0, "min": 60.0, "h": 3600.0},
    ".*": {"m": 1.0, "s": 1.0, "km": 1000.0, "cm": 0.01, "mm": 0.001, "ft": 0.3048, "nmi": 1852.0},
}


def unit_at_end(name: str, ours: str) -> float | None:
    """Return the unit at the end of a name, such as ``psi_deg``, of the quantity ``ours`` [SI], if there is one."""
    stem, _, unit = name.rpartition("_")
    return next(units.get(unit) for own, units in NAME_UNITS.items() if re.fullmatch(own, ours)) if stem else None


def in_si(text: str, ours: str) -> float | str:
    """Return a number with its unit, such as ``8 kn``, as the quantity ``ours`` [SI]; any other text unchanged."""
    found = re.fullmatch(r"\s*([-+]?\d+(?:\.\d+)?)\s*([a-z/]+)\s*", text, re.IGNORECASE)
    unit = unit_at_end(f"{ours}_{found[2].lower().replace('/', '')}", ours) if found else None
    return float(found[1]) * unit if found and unit else text


# Mass density of the air at 15 degrees Celsius [kg/m3].
AIR_DENSITY = 1.225


# Units by their spelling, and physical dimensions as exponents of mass, length and time.
class Dimension(NamedTuple):
    """Physical dimension of a coefficient.

    Examples
    --------
    >>> nw.Dimension(mass=1).unit
    'kg'
    """

    mass: int = 0  #: Exponent of kg [1]
    length: int = 0  #: Exponent of m [1]
    time: int = 0  #: Exponent of s [1]

    @property
    def unit(self) -> str:
        """The SI unit in words, ``kg m/s`` for (1, 1, -1) and ``1`` for a pure number."""
        powers = list(zip(("kg", "m", "s"), self, strict=True))
        above, below = (
            " ".join(f"{name}{abs(n)}".removesuffix("1") for name, n in powers if way * n > 0) for way in (1, -1)
        )
        return (above or "1") + (f"/{below}" if below else "")


NUMBER = Dimension()
KG = Dimension(1)
KG_M = Dimension(1, 1)
KG_M2 = Dimension(1, 2)
KG_PER_M = Dimension(1, -1)
KG_PER_S = Dimension(1, 0, -1)
KG_M_PER_S = Dimension(1, 1, -1)
KG_M2_PER_S = Dimension(1, 2, -1)


@cache
def dimension_of(unit: str) -> Dimension:
    """Return the dimension of an SI unit, or of degrees, in the vocabulary's spelling: ``kg m2``, ``rad/s``, ``1``."""
    above, *below = (unit or "1").split("/")
    known = unit_named("/".join([above, *" ".join(below).split()]))  # All behind the stroke divides
    if known is None or known.scale not in (1.0, DEGREE) or any(known.powers[3:]):
        raise InputError(f"{unit!r} is no unit here; write SI units, as in 'kg m2/s'")
    length, mass, time = known.powers[:3]
    return Dimension(mass, length, time)


def is_unit(word: str) -> bool:
    """Return whether a word, without brackets, is a unit."""
    named = any(character.isalpha() or character == "°" for character in word)
    return named and (word in TEMPERATURES or unit_named(word) is not None)


TEMPERATURES = ("°C", "degC", "°F", "degF")  # Units in tables without a factor to SI


class Unit(NamedTuple):
    """Factor to SI, and powers of metre, kilogram, second, ampere and kelvin."""

    scale: float
    powers: tuple[int, ...] = (0, 0, 0, 0, 0)


BASES = {
    "m": Unit(1.0, (1, 0, 0, 0, 0)), "kg": Unit(1.0, (0, 1, 0, 0, 0)), "s": Unit(1.0, (0, 0, 1, 0, 0)),
    "A": Unit(1.0, (0, 0, 0, 1, 0)), "K": Unit(1.0, (0, 0, 0, 0, 1)),
}  # fmt: skip
# Units by others, the names of one unit together. Angles are dimensionless. One revolution counts as 1 in rpm and rps,
# as usual for propellers, but as 2 pi in "revolution". Names of three letters and more take a plural s.
PREFIXED = {
    "m metre meter": "m", "g gram": "0.001 kg", "s sec second": "s", "N newton": "kg m/s2", "Pa pascal": "N/m2",
    "J joule": "N m", "W watt": "J/s", "Hz hertz": "1/s", "rad radian": "1", "A ampere": "A", "V volt": "W/A",
    "K kelvin": "K",
}  # fmt: skip
WHOLE = {
    "ft foot feet": "0.3048 m", "in inch inches": "ft/12", "yd yard": "3 ft", "mi mile": "1609.344 m",
    "nmi nautical_mile": "1852 m", "t tonne": "1000 kg", "lb pound": "0.45359237 kg", "min minute": "60 s",
    "h hr hour": "3600 s", "d day": "24 h", "kn kt kts knot": "nmi/h", "mph": "mi/h", "kph": "km/h", "mps": "m/s",
    "mps2": "m/s2", "kgf": "9.80665 N", "lbf": "9.80665 lb m/s2", "psi": "lbf/in2", "hp": "550 ft lbf/s",
    "Nm": "N m", "kNm": "kN m", "Nmm": "N mm", "° deg degree": repr(DEGREE), "arcmin arcminute": "deg/60",
    "arcsec arcsecond": "arcmin/60", "revolution turn": "360 deg", "degps": "deg/s", "degps2": "deg/s2",
    "radps": "rad/s", "radps2": "rad/s2", "rpm": "1/min", "rps": "1/s", "% percent": "0.01", "dimensionless": "1",
    "bar": "100000 Pa", "mbar": "100 Pa",
}  # fmt: skip
UNITS = {name: text for names, text in (PREFIXED | WHOLE).items() for name in names.split()}
PREFIXES = {
    "n": 1e-9, "u": 1e-6, "µ": 1e-6, "μ": 1e-6, "m": 1e-3, "c": 1e-2, "d": 1e-1, "h": 1e2, "k": 1e3, "M": 1e6, "G": 1e9,
    "milli": 1e-3, "centi": 1e-2, "kilo": 1e3,
}  # fmt: skip


@cache
def unit_named(text: str) -> Unit | None:
    """Return a unit from its spelling in headers, ``m/s2``, ``kN m`` or ``deg/s^2``; None if it is unknown."""
    products = re.sub(r"(?<=[A-Za-z])[-.](?=[A-Za-z])", "*", text.strip())
    signs = products.replace("**", "^").translate({ord("²"): "^2", ord("³"): "^3", ord("·"): "*", ord("・"): "*"})
    parts = re.split(r"\s*([*/])\s*|\s+", signs)
    scale, powers = 1.0, (0, 0, 0, 0, 0)
    for sign, part in zip(["*", *parts[1::2]], parts[::2], strict=True):
        if (factor := _factor(part)) is None:
            return None
        way = -1 if sign == "/" else 1
        scale = scale / factor.scale if sign == "/" else scale * factor.scale
        powers = tuple(a + way * b for a, b in zip(powers, factor.powers, strict=True))  # type: ignore[assignment]
    return Unit(scale, powers)


def _factor(text: str) -> Unit | None:
    """A number, a unit, or a power of one."""
    if known := _single(text):
        return known
    if re.fullmatch(r"\d+(\.\d+)?(e[+-]?\d+)?", text) and 0 < float(text) < math.inf:
        return Unit(float(text))
    power = re.fullmatch(r"(\D+?)(?:\^?(\d)|\^\(?(-\d)\)?)", text)
    if power is None or (known := _single(power[1])) is None:
        return None
    exponent = int(power[2] or power[3])
    return Unit(known.scale**exponent, tuple(exponent * one for one in known.powers))


@cache
def _single(word: str) -> Unit | None:
    """A unit by its name, singular or plural, with or without a prefix."""
    for name in (word, word.removesuffix("s") if len(word) > 3 else word):
        if known := BASES.get(name) or (unit_named(UNITS[name]) if name in UNITS else None):
            return known
        for prefix, factor in PREFIXES.items():
            one = name.removeprefix(prefix)
            if one != name and any(one in names.split() for names in PREFIXED) and (known := _single(one)):
                return Unit(factor * known.scale, known.powers)
    return None
