"""Verbs whose options come in groups: a parameter that is a dataclass stands for an option a field."""

from collections.abc import Callable
from dataclasses import MISSING, fields, is_dataclass
from functools import wraps
from inspect import Parameter, Signature, signature
from typing import Any, get_type_hints

from narrows.cli.app import app

Verb = Callable[..., None]


def verb(example: str, name: str | None = None) -> Callable[[Verb], Verb]:
    """Return what makes a function a verb of the command line."""

    def registered(function: Verb) -> Verb:
        app.command(name, epilog=f"Example: {example}")(with_single_options(function))
        return function

    return registered


def with_single_options(function: Verb) -> Verb:
    """Return a function that takes an option for each field of the groups that another takes."""
    hints = get_type_hints(function, include_extras=True)
    own = signature(function).parameters
    groups = {name: hints[name] for name in own if is_dataclass(hints[name])}
    options = [option for name in own for option in _options(own[name], hints[name])]

    @wraps(function)
    def called(**given: Any) -> None:
        made = {name: kind(**{one.name: given.pop(one.name) for one in fields(kind)}) for name, kind in groups.items()}
        function(**given, **made)

    called.__signature__ = Signature(options)  # type: ignore[attr-defined]
    called.__annotations__ = {option.name: option.annotation for option in options}
    return called


def _options(parameter: Parameter, kind: Any) -> list[Parameter]:
    """A parameter as the options that it stands for."""
    if not is_dataclass(kind):
        return [parameter.replace(annotation=kind, kind=Parameter.KEYWORD_ONLY)]
    hints = get_type_hints(kind, include_extras=True)
    return [
        Parameter(
            one.name,
            Parameter.KEYWORD_ONLY,
            default=Parameter.empty if one.default is MISSING else one.default,
            annotation=hints[one.name],
        )
        for one in fields(kind)
    ]
