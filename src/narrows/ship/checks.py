"""Rules of particulars: one definition each, for numbers in files and for columns of an ensemble."""

import math
import operator
from collections.abc import Callable, Collection, Iterable, Mapping
from numbers import Real
from typing import Any, NamedTuple

import numpy as np

from narrows.base.errors import InputError, shown
from narrows.quantities.names import Number

# Range of every size of a ship, its water and its parts; products of them stay finite.
SMALLEST, LARGEST = 1e-12, 1e20
# Sections of a file for quantities that are not the ship's own.
SECTIONS = {"width": "canal", "depth": "canal", "density": "water"}
POSITIVE = (
    "length", "beam", "draft", "block_coefficient", "mass", "inertia", "flow_straightening", "width", "depth",
    "density", "limit_deg", "rate_deg", "propeller_diameter", "rudder_area", "rudder_lift",
    "rudder_wake_ratio", "rudder_in_slipstream",
)  # fmt: skip


# K_T ahead is a parabola: with the sign of the revolutions changed it would push the ship ahead.
ASTERN = ("propeller_astern_0", "propeller_astern_1", "propeller_astern_2")
AHEAD_ONLY = (
    "the thrust of this propeller is known ahead only, so that it cannot turn astern; give [propeller] astern_0 to "
    "astern_2, as nw.with_astern_thrust does, or revolutions from 0 (stopped)"
)


class Rule(NamedTuple):
    asks: tuple[str, ...]  # Names of the particulars
    # Returns True if the rule holds, for numbers or for columns in the order of the names; False for NaN
    right: Callable[..., Any]
    sentence: str  # Message of a broken rule, with the places and values of the particulars


# Every rule in addition to finiteness.
RULES = (
    *(Rule((name,), lambda value: value > SMALLEST, f"{{{name}}} must be positive, in SI units") for name in POSITIVE),
    Rule(
        ("revolutions", *ASTERN),
        lambda value, *astern: (value >= 0) | (sum(map(abs, astern)) > 0),
        f"{{revolutions}}: {AHEAD_ONLY}",
    ),
    Rule(("block_coefficient",), lambda value: value <= 1, "{block_coefficient} is over 1; it is a fraction, as 0.65"),
    Rule(("limit_deg",), lambda value: value <= 90, "{limit_deg} is beyond 90 degrees; check it"),
    *(
        Rule((name,), lambda value: value >= 0, f"{{{name}}} is negative; give a number from 0")
        for name in ("dead_time", "lag", "dead_band_deg")
    ),
    Rule(("pumps",), lambda value: (value == 1) | (value == 2), "{pumps}: a steering gear runs 1 pump or 2"),
    Rule(
        ("propeller_wake",),
        lambda value: (value >= 0) & (value < 1),
        "{propeller_wake} is no fraction; give one from 0 to less than 1",
    ),
    Rule(("beam", "width"), operator.lt, "{beam} m does not fit in {width} m; check both, in metres and at one scale"),
    Rule(("draft", "beam"), operator.le, "{draft} m is more than {beam} m; check both, in metres and at one scale"),
    Rule(("draft", "depth"), operator.lt, "{depth} m leaves no water under {draft} m; check both"),
)


def check_particulars(values: Mapping[str, Number], places: Mapping[str, str] | None = None) -> None:
    """Raise if particulars break a rule; numbers or columns."""
    known = {name: value for name, value in values.items() if value is not None}
    places = {name: place_of(name) for name in known} | dict(places or {})
    for name, value in known.items():
        check_number(places[name], value)
    for rule in RULES:
        if all(name in known for name in rule.asks):
            asked = {name: known[name] for name in rule.asks}
            check_rule(rule.right(*asked.values()), rule.sentence, asked, places)


def check_ahead(revolutions: Number | None, propeller: Any) -> None:
    """Raise if a propeller turns astern whose thrust is known ahead only."""
    known = getattr(propeller, "turns_astern", False)
    if revolutions is not None and not known and np.any(np.asarray(revolutions) < 0):
        raise InputError(f"revolutions = {float(np.min(revolutions)):g} 1/s: {AHEAD_ONLY}")


# Largest angles [rad]: beyond them a number is one in degrees.
LARGEST_ANGLES = {"psi": math.pi, "rudder": math.pi / 2}


def check_angles(values: Mapping[str, Any]) -> None:
    """Raise if a heading or a rudder angle, or one of a column, is in degrees."""
    for name in LARGEST_ANGLES.keys() & values.keys():
        try:
            angles = np.ravel(np.asarray(values[name], float))
        except (TypeError, ValueError):
            raise InputError(f"{name} = {shown(values[name])} is no angle; give radians, as np.radians(10)") from None
        largest = float(angles[np.argmax(np.abs(angles))]) if angles.size else 0.0
        if abs(largest) > LARGEST_ANGLES[name] * (1 + 1e-9):  # pi of a file or of single precision is allowed
            raise InputError(
                f"{name} = {largest:g} rad is {math.degrees(largest):.0f} degrees; give radians ({name} = "
                f"{math.radians(largest):.3g} for {largest:g} degrees)"
            )


def place_of(name: str) -> str:
    """Return the section and key of a particular of ship, canal or water in a file."""
    return f"[{SECTIONS.get(name, 'ship')}] {name}"


def check_number(location: str, value: object) -> None:
    """Raise if a value, or one of a column, is not a finite number."""
    known: Any = value
    finite = np.isfinite(known) if hasattr(value, "dims") else is_finite(value)
    if finite is True and abs(known) < LARGEST:  # A plain number, in a twentieth of the time of a column
        return
    check_rule(finite, "{} is not a finite number; give it in SI units", {"": value}, {"": location})
    check_rule(abs(known) < LARGEST, "{} is beyond all measure; check its unit", {"": value}, {"": location})


def check_sizes(thing: object, over: Collection[str] = (), names: Iterable[str] = ()) -> None:
    """Raise if a number of a dataclass, of all or these, is negative or not finite, or 0 if it must be over 0."""
    for name in names or vars(thing):
        value, usual = getattr(thing, name), getattr(type(thing), name, "")
        if (isinstance(value, str) and isinstance(usual, str) and not names) or value is None is usual:
            continue
        if not is_finite(value) or value < 0 or (name in over and value == 0):
            least = "over 0" if name in over else "from 0"
            raise InputError(f"{type(thing).__name__}: {name} = {shown(value)}: give a finite number {least}")


def is_finite(value: object) -> bool:
    """Return whether a value is a finite number within the range of a float."""
    try:
        return not isinstance(value, bool) and isinstance(value, Real) and math.isfinite(value)
    except OverflowError:  # An integer with more digits than a float
        return False


def check_rule(right: Any, sentence: str, values: Mapping[str, Any], places: Mapping[str, str]) -> None:
    """Raise the sentence with places and values, if a rule is broken: for a column with the place of the first hit."""
    if np.all(right):
        return
    at: dict[str, int] = {}
    if hasattr(right, "dims"):
        first = np.unravel_index(int(np.argmin(right.to_numpy())), right.shape)
        at = {str(name): int(index) for name, index in zip(right.dims, first, strict=True)}
    words = {name: f"{places[name]} = {shown(_picked(value, at))}" for name, value in values.items()}
    where = ", ".join(f"{name} = {right[name].to_numpy()[index]}" for name, index in at.items() if name not in values)
    raise InputError(sentence.format(*words.values(), **words) + (f" (the first is at {where})" if where else ""))


def _picked(value: Any, at: Mapping[str, int]) -> Any:
    if hasattr(value, "dims"):
        value = float(value.isel({name: index for name, index in at.items() if name in value.dims}))
    return float(f"{value:.8g}") if isinstance(value, float) else value


def check_fields(part: object, names: Mapping[str, str], section: str) -> None:
    """Raise if the numbers of a section of a ship file are columns, not finite or break a rule."""
    values = {name: getattr(part, key) for key, name in names.items()}
    places = {name: f"[{section}] {key}" for key, name in names.items()}
    for name, value in values.items():
        if hasattr(value, "dims"):
            raise InputError(f"{places[name]} is a column, and not a finite number; vary it in an ensemble")
    check_particulars(values, places)
