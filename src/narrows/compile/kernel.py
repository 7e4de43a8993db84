"""The kernel of a fleet: the text of one file that Numba compiles, a model's equations stepped over a block of lanes.

What makes it fast was tried on the paper's model (``benchmarks/kernel.py``). A block sits in ONE flat array, field
after field at constant offsets, so that LLVM proves that nothing aliases. Each stage of the Runge-Kutta step is a
loop of its own: one long loop for all four is a longer chain than a processor looks ahead. No loop branches on data.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from narrows.compile.emit import POSE, Emitted
from narrows.compile.exponential import exponential_text
from narrows.compile.spell import BLOCK
from narrows.compile.trace import ACCELERATIONS, STATE, symbol

Precision = Literal["float64", "float32"]
LANES = 64
DERIVATIVES = (*(f"d_{name}" for name in STATE[:4]), *ACCELERATIONS.values())

HEADER = '''"""Made by narrows {version} from a table of terms: made again where it is missing, so do not edit."""
from math import sqrt

import numba
import numpy as np
from numpy import {precision} as real

FAST = {{"nsz", "contract"}}  # fused multiply-add, nothing that reorders: the mirrored voyage is the mirror to the bit
jit = numba.njit(fastmath=FAST, error_model="numpy", nogil=True)
cached = numba.njit(fastmath=FAST, error_model="numpy", nogil=True, cache=True)
LANES, FIELDS = {lanes}, {fields}
'''
LARGER = """
@jit
def larger(a, b):
    return a if a > b else b


@jit
def smaller(a, b):
    return a if a < b else b
"""


@dataclass(frozen=True)
class Fields:
    """Where each field of a block starts.

    Parameters
    ----------
    moving : tuple of str
        The parts of the state that change.
    felt : tuple of str
        Those of them that the derivatives depend on.
    own : tuple of str
        The constants that each lane has of its own.
    """

    moving: tuple[str, ...]
    felt: tuple[str, ...]
    own: tuple[str, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Every field in order."""
        old = (f"old {name}" for name in STATE)
        sums = (f"{which} {name}" for which in ("first", "middle") for name in self.moving)
        return (*STATE, "step", "left", "flag", *old, *(f"stage {name}" for name in self.felt), *sums, *self.own)

    def __getitem__(self, name: str) -> str:
        """The text of a lane's entry in a field."""
        return f"block[{self.names.index(name)} * LANES + lane]"


def kernel_text(emitted: Emitted, varying: bool, precision: Precision, version: str) -> str:
    """Write the module that sails a fleet.

    Parameters
    ----------
    emitted : Emitted
        The equations, with no inputs as arguments.
    varying : bool
        Whether the constants differ from vessel to vessel.
    precision : {"float64", "float32"}
        Of a lane.
    version : str
        Of narrows.
    """
    fields = _fields(emitted, emitted.constants.names if varying else ())
    functions = [f"@jit\n{emitted.function(name, BLOCK)}" for name in ("rhs", "gap", "lean")]
    header = HEADER.format(version=version, precision=precision, lanes=LANES, fields=len(fields.names))
    return "\n\n".join(
        [
            header,
            emitted.prologue(),
            *_helpers("".join(functions), precision),
            *functions,
            *(_own_constants(fields) if varying else _shared_constants(emitted.constants.names)),
            _function("step(block, limits, constants)", _step(fields)),
            (Path(__file__).parent / "lanes.py").read_text(encoding="utf-8"),
        ]
    )


def _helpers(text: str, precision: Precision) -> Iterator[str]:
    """The functions that a text calls, beside the C library's."""
    if "exp(" in text:
        yield exponential_text(precision)
    if "larger(" in text:
        yield LARGER


def _fields(emitted: Emitted, own: tuple[str, ...]) -> Fields:
    pairs = list(zip(STATE, emitted.derivatives, strict=True))
    moving = tuple(name for name, derivative in pairs if derivative != 0)
    asked = set().union(*(derivative.free_symbols for _, derivative in pairs))
    return Fields(moving, tuple(name for name in moving if symbol(name) in asked), own)


def _function(signature: str, body: Iterable[str]) -> str:
    return "\n    ".join([f"@jit\ndef {signature}:", *body]) + "\n"


def _shared_constants(names: tuple[str, ...]) -> list[str]:
    values = "".join(f"constants[{number}], " for number in range(len(names)))
    return [
        _function("uniform(constants)", [f"return ({values})"]),
        _function("of_lane(block, lane, constants)", ["return constants"]),
        _function("take_constants(block, lane, constants, vessel)", ["pass"]),
    ]


def _own_constants(fields: Fields) -> list[str]:
    values = "".join(f"{fields[name]}, " for name in fields.own)
    copies = [f"{fields[name]} = constants[vessel, {number}]" for number, name in enumerate(fields.own)]
    return [
        _function("uniform(constants)", ["return constants"]),
        _function("of_lane(block, lane, constants)", [f"return ({values})"]),
        _function("take_constants(block, lane, constants, vessel)", copies),
    ]


def _step(fields: Fields) -> Iterator[str]:
    yield "least_cos, most_speed, most_rate = limits[LEAST_COS], limits[MOST_SPEED], limits[MOST_RATE]"
    for stage in (1, 2, 3, 4):
        yield "all_well = True"
        yield "for lane in range(LANES):"
        yield from (f"    {line}" for line in _stage(stage, fields))
    yield "return not all_well"


def _stage(stage: int, fields: Fields) -> Iterator[str]:
    """One of the four stages of a classical Runge-Kutta step."""
    for name in STATE:
        staged = stage > 1 and name in fields.felt
        yield f"{name} = {fields[f'stage {name}' if staged else name]}"
    yield "own = of_lane(block, lane, constants)"
    yield f"pace = {fields['step']}"
    yield f"{', '.join(DERIVATIVES)} = rhs({', '.join(STATE)}, *own)"
    pairs = [(name, d) for name, d in zip(STATE, DERIVATIVES, strict=True) if name in fields.moving]
    yield from _last(fields, pairs) if stage == 4 else _early(stage, fields, pairs)


def _early(stage: int, fields: Fields, pairs: list[tuple[str, str]]) -> Iterator[str]:
    yield "ahead = pace" if stage == 3 else "ahead = real(0.5) * pace"
    for name, derivative in pairs:
        if name in fields.felt:
            yield f"{fields[f'stage {name}']} = {fields[name]} + ahead * {derivative}"
        total = fields[f"{'first' if stage == 1 else 'middle'} {name}"]
        yield f"{total} {'+=' if stage == 3 else '='} {derivative}"


def _last(fields: Fields, pairs: list[tuple[str, str]]) -> Iterator[str]:
    yield "sixth = pace * real(1.0 / 6.0)"
    for name, derivative in pairs:
        yield f"{fields[f'old {name}']} = {fields[name]}"
        first, middle = fields[f"first {name}"], fields[f"middle {name}"]
        # additions, for processors whose multipliers are the narrow place
        yield f"{name} = {fields[name]} + sixth * (({first} + {derivative}) + ({middle} + {middle}))"
    yield "unit = real(1.5) - real(0.5) * (cos_psi * cos_psi + sin_psi * sin_psi)"
    yield "cos_psi, sin_psi = cos_psi * unit, sin_psi * unit"
    yield from (f"{fields[name]} = {name}" for name in fields.moving)
    yield f"left = {fields['left']} - real(1.0)"
    yield f"{fields['left']} = left"
    yield f"room = gap({', '.join(POSE)}, *own)"
    yield "well = (room > real(0.0)) & (left > real(0.0)) & (cos_psi > least_cos)"
    yield "well = well & (abs(v) < most_speed) & (abs(r) < most_rate) & (abs(u) < most_speed)"
    yield f"{fields['flag']} = real(0.0) if well else real(1.0)"
    yield "all_well = all_well & well"
