"""Every quantity of physics, tables and files: one name, one unit, one meaning."""

import inspect
import math
import re
from collections.abc import Callable, Mapping
from functools import lru_cache
from types import FunctionType
from typing import Any, NamedTuple

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
    r"(?:.*_)?(?:psi|heading|rudder|r)": {"deg": DEGREE, "rad": 1.0},
    "duration|dt": {"s": 1.0, "min": 60.0, "h": 3600.0},
    ".*": {"m": 1.0, "s": 1.0},
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
