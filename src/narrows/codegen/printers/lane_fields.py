"""Where numbers lie that one loop over lanes makes and a later one reads."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import sympy

from narrows.codegen.free_motion import Expr
from narrows.codegen.lines import Assignment


@dataclass(frozen=True)
class LaneFields:
    """Fields of a lane; one is used again once what was in it is dead."""

    parts: Sequence[Sequence[Assignment]]  # The rounds, a loop over lanes each
    results: tuple[Expr, ...]  # What the last of them gives
    first: tuple[str, ...] = ()  # Numbers that have the first fields for good

    @cached_property
    def _last_use(self) -> dict[str, int]:
        """The last round in which each number is read."""
        last = {name: number for number, part in enumerate(self.parts) for _, value in part for name in names_in(value)}
        return last | {name: len(self.parts) - 1 for value in self.results for name in names_in(value)}

    @cached_property
    def fields(self) -> dict[str, int]:
        """The field of each number that is kept from round to round."""
        index = {name: number for number, name in enumerate(self.first)}
        total, free, busy = len(index), list[int](), list[str]()
        for number, part in enumerate(self.parts):
            for name in [name for name in busy if self._last_use[name] < number]:
                busy.remove(name)
                free.append(index[name])
            for name in (str(target) for target, _ in part):
                if self._last_use.get(name, -1) > number:
                    index[name] = free.pop() if free else total
                    total += index[name] == total
                    busy.append(name)
        return index

    @property
    def size(self) -> int:
        """Fields of a lane."""
        return max(self.fields.values(), default=-1) + 1

    def read(self, number: int) -> set[str]:
        """Return what a round asks for and does not make, the last one for the results too."""
        part = self.parts[number]
        values = [*(value for _, value in part), *(self.results if number == len(self.parts) - 1 else ())]
        return {name for value in values for name in names_in(value)} - {str(target) for target, _ in part}

    def stored(self, number: int) -> list[str]:
        """Return what a round makes for later ones, in alphabetical order."""
        made = {str(target) for target, _ in self.parts[number]}
        return sorted(name for name in made if self._last_use.get(name, -1) > number)


def names_in(value: Expr) -> set[str]:
    """Return the names that an expression asks for."""
    return {str(s) for s in sympy.sympify(value).free_symbols}
