"""The rates of a ship's state as straight lines, with what is constant through a voyage apart."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import sympy

from narrows.codegen.free_motion import ACCELERATIONS, INPUTS, STATE, Expr, FreeMotion, symbol
from narrows.codegen.lines import Assignment, Constants, Lines, real, straight_lines

TURNED = ("cos_psi", "sin_psi", "u", "v", "r")


@dataclass(frozen=True)
class Rates:
    """The rates of ``STATE`` by state, controls, section of the water and constants."""

    motion: FreeMotion  # The equations of motion
    # Quantities that change within a voyage beside the state: of actuators that move, of the section, forces from
    # outside
    moving: tuple[str, ...]
    pushed: bool = False  # Whether forces from outside act

    @cached_property
    def _parts(self) -> tuple[Constants, tuple[Expr, ...]]:
        constants = Constants({s for name, s in self.motion.names.items() if name not in self.moving})
        pushed = {f: symbol(INPUTS[f]) for f in self.motion.freedoms} if self.pushed else {}
        return constants, _derivatives(self.motion, constants.lift, pushed)

    @property
    def constants(self) -> Constants:
        """What stays the same through a voyage, by the names of the lines."""
        return self._parts[0]

    @property
    def parameters(self) -> dict[str, Expr]:
        """The symbols of what the constants are made of, by the names of the vocabulary."""
        used = set().union(*(expression.free_symbols for expression in self.constants.table))
        return {name: symbol for name, symbol in self.motion.names.items() if symbol in used}

    @property
    def derivatives(self) -> tuple[Expr, ...]:
        return self._parts[1]

    @cached_property
    def lines(self) -> tuple[list[Assignment], list[Expr]]:
        """The rates as straight lines, and the results in terms of them."""
        return straight_lines(self.derivatives)

    def depend_on(self, name: str) -> bool:
        return any(symbol(name) in rate.free_symbols for rate in self.derivatives)

    def written(self, lines: Lines, tag: str, values: Mapping[str, Expr]) -> dict[str, Expr]:
        where = {symbol(name): value for name, value in values.items()}
        results = lines.inline(f"e{tag}_", *self.lines, where)
        return {name: lines.put(f"d{tag}_{name}", rate) for name, rate in zip(STATE, results, strict=True)}

    def program(self) -> tuple[Lines, dict[str, Expr]]:
        lines = Lines()
        names = {*STATE, *self.moving}
        return lines, self.written(lines, "", {name: real(name) for name in names})


def _derivatives(motion: FreeMotion, lift: Callable[[Expr], Expr], pushes: Mapping[str, Expr]) -> tuple[Expr, ...]:
    c, s, u, v, r = (symbol(name) for name in TURNED)
    basis = [lift(expression) for expression in motion.basis]
    accelerations = dict.fromkeys(ACCELERATIONS, sympy.Integer(0))
    for force, gains, row in zip(motion.freedoms, motion.gains, motion.pushes, strict=True):
        parts = [(lift(gain), function) for gain, function in zip(gains, basis, strict=True)]
        pushed = sum((lift(part * pushes[f]) for f, part in zip(motion.freedoms, row, strict=True) if f in pushes), 0)
        accelerations[force] = _grouped(parts, (v, r)) + pushed
    return (u * c - v * s, u * s + v * c, -r * s, r * c, *accelerations.values())


def _grouped(parts: Iterable[tuple[Expr, Expr]], factors: Sequence[Expr]) -> Expr:
    """Sum gains times functions, with what multiplies each factor gathered: v (k0 + k1 |v|), not k0 v + k1 |v| v."""
    total, gathered = sympy.Integer(0), dict.fromkeys(factors, sympy.Integer(0))
    for gain, basis in parts:
        factor = next((f for f in factors if f in sympy.Mul.make_args(basis)), None)
        if factor is None:
            total += gain * basis
        else:
            gathered[factor] += gain * (basis / factor)
    return total + sum((factor * inner for factor, inner in gathered.items()), sympy.Integer(0))
