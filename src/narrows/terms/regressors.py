"""Regressors composed of physics functions."""

from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

from narrows.quantities.names import Number, argument_names, name_of


@dataclass(frozen=True)
class Composed:
    """A law whose first argument is the result of another function."""

    law: Callable[..., Number]  # Function of that result, then of names of the vocabulary
    parameter: Callable[..., Number]  # Function of names of the vocabulary

    @cached_property
    def inputs(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys((*argument_names(self.parameter), *argument_names(self.law)[1:])))

    @property
    def name(self) -> str:
        return f"{name_of(self.parameter)}_{name_of(self.law)}"

    def __call__(self, *values: Number) -> Number:
        at = dict(zip(self.inputs, values, strict=True))
        result = self.parameter(*[at[name] for name in argument_names(self.parameter)])
        return self.law(result, *[at[name] for name in argument_names(self.law)[1:]])


@dataclass(frozen=True)
class Grouped:
    """A function of several quantities as one object."""

    function: Callable[[Any], Number]  # Function of that object
    quantities: type  # Dataclass whose fields are names of the vocabulary

    @cached_property
    def inputs(self) -> tuple[str, ...]:
        return tuple(entry.name for entry in fields(self.quantities))

    @property
    def name(self) -> str:
        return name_of(self.function)

    def __call__(self, *values: Number) -> Number:
        return self.function(self.quantities(*values))
