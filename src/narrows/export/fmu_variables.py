"""The variables of an FMU: a value reference is a place in the one array of ``fmi/instance.h``."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from types import MappingProxyType

from narrows.codegen.free_motion import OPEN
from narrows.codegen.linearisation import LINEARISED
from narrows.export.exported_ship import ExportedNumber, ExportedShip
from narrows.export.passport import RANGE_BITS, bits_in_words
from narrows.quantities.dimensions import dimension_of
from narrows.quantities.names import MOTION
from narrows.ship.checks import POSITIVE, SMALLEST


class Kind(StrEnum):
    """Kind of a variable: its letter in ``KINDS`` of C; causality, variability and initial of the standard."""

    causality: str
    variability: str
    initial: str  # Empty where the standard forbids it

    def __new__(cls, letter: str, causality: str, variability: str, initial: str) -> "Kind":
        own = str.__new__(cls, letter)
        own._value_ = letter
        own.causality, own.variability, own.initial = causality, variability, initial
        return own

    TIME_ITSELF = "t", "independent", "continuous", ""
    STATE = "s", "output", "continuous", "exact"
    RATE = "d", "local", "continuous", "calculated"
    CALCULATED = "c", "output", "continuous", "calculated"
    TRUTH = "b", "output", "discrete", "calculated"
    WHOLE = "i", "output", "discrete", "calculated"
    MOMENT = "o", "output", "discrete", "calculated"
    FIXED = "f", "parameter", "fixed", "exact"
    INPUT = "u", "input", "continuous", ""
    TUNABLE = "p", "parameter", "tunable", "exact"
    INDICATOR = "n", "local", "continuous", "calculated"


REALS, INTEGERS = "tsdcofupn", "i"
UNKNOWNS, KNOWNS = "sdcn", "sup"
HEADING = "heading, positive clockwise seen from above"
SIDES = ("starboard", "port")
PER_SECOND = {"m": "m/s", "rad": "rad/s", "m/s": "m/s2", "rad/s": "rad/s2"}
# Outcomes of a voyage, in the order of the codes in C, with the reason in words.
OUTCOMES = {
    "afloat": "the voyage goes on",
    "grounded": "the hull has touched a bank and lies still",
    "diverged": "the numbers are no longer valid",
    "outside": "the ship lies across the canal and lies still",
    "astern": "the ship left the waterway at its beginning and lies still",
    "passed": "the ship has passed the end of the waterway and lies still",
}
# Longest step of co-simulation, as a multiple of the ship's default step: ten steps a ship length.
LONGEST_STEP = 20.0
WIDEST = (-math.inf, math.inf)
# Particulars with an upper bound of their own.
HIGHEST = MappingProxyType({"block_coefficient": 1.0, "rudder_limit": math.pi / 2})


@dataclass(frozen=True)
class FmuVariable:
    name: str  # Name in the FMU
    kind: Kind
    unit: str  # SI unit
    meaning: str  # Meaning in words
    start: float | None = None  # Start value, if it may be set
    derivative: int = 0  # Value reference of the variable that it differentiates; 0 for none
    bounds: tuple[float, float] = WIDEST  # Limits for an importer
    reference: int = 0  # Value reference


def variables_of(exported: ExportedShip, speed: float, dt: float) -> tuple[FmuVariable, ...]:
    return tuple(replace(one, reference=place) for place, one in enumerate(_variables(exported, speed, dt)))


def indicators(exported: ExportedShip) -> tuple[tuple[str, str, str], ...]:
    """Return name, outcome and meaning of each event indicator: below 0 the voyage has ended."""
    banks = [(f"contact_{side}", "grounded", f"the clearance to {side}") for side in SIDES]
    along = [
        ("end_ahead", "passed", "the distance to the end ahead"),
        ("end_astern", "astern", "the distance to the end astern"),
    ]
    across = [("heading_across", "outside", "cosine of the heading over its least")]
    has_banks = exported.ship.shape != OPEN
    return tuple((banks + across) * has_banks + along * (exported.waterway is not None))


def _variables(exported: ExportedShip, speed: float, dt: float) -> Iterator[FmuVariable]:
    yield FmuVariable("time", Kind.TIME_ITSELF, "s", "time")
    states = tuple(_states(exported))
    for name, unit, meaning in states:
        yield FmuVariable(name, Kind.STATE, unit, meaning, speed if name == "u" else 0.0)
    for number, (name, unit, _) in enumerate(states):
        yield FmuVariable(f"der({name})", Kind.RATE, PER_SECOND.get(unit, "1/s"), f"rate of {name}", None, number + 1)
    if exported.ship.shape != OPEN:
        for side in SIDES:
            yield FmuVariable(f"clearance_{side}", Kind.CALCULATED, "m", f"clearance to {side} of the hull")
    yield FmuVariable(
        "aground", Kind.TRUTH, "1", "whether the hull has touched a bank; from then on the ship lies still"
    )
    outcomes = "; ".join(f"{code} {name}, {words}" for code, (name, words) in enumerate(OUTCOMES.items()))
    yield FmuVariable("outcome", Kind.WHOLE, "1", f"outcome of the voyage: {outcomes}")
    yield FmuVariable("side", Kind.WHOLE, "1", "side of the bank that was touched: 1 starboard, -1 port, 0 none")
    yield FmuVariable("outcome_time", Kind.MOMENT, "s", "time of the end of the voyage; 0 until then")
    beyond = f"{bits_in_words(exported.ship.model)}, {RANGE_BITS['bottom'][0]} bottom"
    yield FmuVariable("beyond", Kind.WHOLE, "1", f"quantities outside the tested range, a sum of: {beyond}")
    yield FmuVariable("step", Kind.FIXED, "s", "longest step of co-simulation", dt, 0, (SMALLEST, LONGEST_STEP * dt))
    for one in exported.inputs:
        yield FmuVariable(one.name, Kind.INPUT, one.unit, one.meaning, one.value)
    for one in exported.parameters:
        name, bounds = f"parameters.{one.name}", _bounds(exported, one)
        yield FmuVariable(name, Kind.TUNABLE, one.unit, one.meaning, one.value, 0, bounds)
    for name, _, meaning in indicators(exported):
        yield FmuVariable(name, Kind.INDICATOR, "1" if "heading" in name else "m", f"event indicator: {meaning}")


def _states(exported: ExportedShip) -> Iterator[tuple[str, str, str]]:
    for name in LINEARISED:
        yield name, *((MOTION[name].unit, MOTION[name].meaning) if name in MOTION else ("rad", HEADING))
    known = {one.name: one for one in exported.state}
    yield from ((name, known[name].unit, known[name].meaning) for name in exported.portable.gear)


def _bounds(exported: ExportedShip, one: ExportedNumber) -> tuple[float, float]:
    terms = exported.ship.model.terms
    positive = one.name in POSITIVE or (one.name.endswith(("_limit", "_rate")) and not one.name.endswith("wake_rate"))
    low, high = terms[one.name].bound if one.name in terms.names else (SMALLEST if positive else -math.inf, math.inf)
    return min(low, one.value), max(min(high, HIGHEST.get(one.name, math.inf)), one.value)


def unit_powers(unit: str) -> Mapping[str, int]:
    """Return a unit as powers of base units, ``kg m/s2`` as kg 1, m 1, s -2."""
    dimension = dimension_of(unit)
    powers = {"kg": dimension.mass, "m": dimension.length, "s": dimension.time, "rad": int(unit.startswith("rad"))}
    return {base: power for base, power in powers.items() if power}
