"""The rates of the state of one ship by its equations of motion, in lines."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import sympy

from narrows.codegen.expressions import symbols_of
from narrows.codegen.free_motion import ACCELERATIONS, INPUTS, STATE, Expr, FreeMotion, symbol
from narrows.codegen.lines import Assignment, Constants, Lines, real, straight_lines

TURNED = ("cos_psi", "sin_psi", "u", "v", "r")


@dataclass(frozen=True)
class Rates:
    """The rates of ``STATE`` by state, controls, section of the water and constants."""

    motion: FreeMotion  # The equations of motion
    # Quantities that change within a voyage besides the state: moving actuators, the section, external forces
    moving: tuple[str, ...]
    pushed: bool = False  # True if external forces act

    @cached_property
    def constants(self) -> Constants:
        """Quantities that stay constant through a voyage, by their names in the lines."""
        constants = self._parts[0]
        return Constants(constants.parameters, dict(constants.table))  # Exports lift more into their own.

    @property
    def _parts(self) -> tuple[Constants, tuple[Expr, ...], tuple[list[Assignment], list[Expr]]]:
        return _rate_lines(self.motion, self.moving, self.pushed)

    @property
    def parameters(self) -> dict[str, Expr]:
        """Symbols that the constants are computed from, by the names of the vocabulary."""
        used = set().union(*map(symbols_of, self.constants.table))
        return {name: symbol for name, symbol in self.motion.names.items() if symbol in used}

    def depend_on(self, name: str) -> bool:
        return any(symbol(name) in symbols_of(rate) for rate in self._parts[1])

    def written(self, lines: Lines, tag: str, values: Mapping[str, Expr]) -> dict[str, Expr]:
        where = {symbol(name): value for name, value in values.items()}
        results = lines.inline(f"e{tag}_", *self._parts[2], where)
        return {name: lines.put(f"d{tag}_{name}", rate) for name, rate in zip(STATE, results, strict=True)}

    def program(self) -> tuple[Lines, dict[str, Expr]]:
        lines = Lines()
        names = {*STATE, *self.moving}
        return lines, self.written(lines, "", {name: real(name) for name in names})


@lru_cache(maxsize=32)
def _rate_lines(
    motion: FreeMotion, moving: tuple[str, ...], is_pushed: bool
) -> tuple[Constants, tuple[Expr, ...], tuple[list[Assignment], list[Expr]]]:
    """Constants, derivatives of the state, and those as straight lines: the same for every law and contact."""
    constants = Constants({s for name, s in motion.names.items() if name not in moving})
    pushes, lift = {f: symbol(INPUTS[f]) for f in motion.components} if is_pushed else {}, constants.lift
    c, s, u, v, r = (symbol(name) for name in TURNED)
    basis = [lift(expression) for expression in motion.basis]
    accelerations = dict.fromkeys(ACCELERATIONS, sympy.Integer(0))
    for force, gains, row in zip(motion.components, motion.gains, motion.pushes, strict=True):
        parts = [(lift(gain), function) for gain, function in zip(gains, basis, strict=True)]
        pushed = sum((lift(part * pushes[f]) for f, part in zip(motion.components, row, strict=True) if f in pushes), 0)
        accelerations[force] = _grouped(parts, (v, r)) + pushed
    derivatives = (u * c - v * s, u * s + v * c, -r * s, r * c, *accelerations.values())
    return constants, derivatives, straight_lines(derivatives)


def _grouped(parts: Iterable[tuple[Expr, Expr]], factors: Sequence[Expr]) -> Expr:
    """Sum gains times functions with factors collected: v (k0 + k1 |v|), not k0 v + k1 |v| v."""
    total, gathered = sympy.Integer(0), dict.fromkeys(factors, sympy.Integer(0))
    for gain, basis in parts:
        factor = next((f for f in factors if f in sympy.Mul.make_args(basis)), None)
        if factor is None:
            total += gain * basis
        else:
            gathered[factor] += gain * (basis / factor)
    return total + sum((factor * inner for factor, inner in gathered.items()), sympy.Integer(0))
