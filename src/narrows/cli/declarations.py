"""Arguments and options of verbs, declared by annotation: ``Annotated[float, Option(help="...")]``."""

from collections.abc import Callable, Iterator
from dataclasses import MISSING, fields, is_dataclass
from inspect import Parameter, signature
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Union, get_args, get_origin, get_type_hints

import click

TYPES: dict[type, click.ParamType[Any, Any]] = {
    float: click.FLOAT, int: click.INT, str: click.STRING, Path: click.Path(path_type=Path),
}  # fmt: skip


class Text(click.ParamType[Any, Any]):
    """Reads a value from the name of its option and a text; a default is written as a user would."""

    name = "text"

    def __init__(self, read: Callable[[str, str], Any]) -> None:
        self.read = read

    def convert(self, value: Any, parameter: click.Parameter | None, context: click.Context | None) -> Any:
        return self.read(parameter.opts[0], value) if parameter and isinstance(value, str) else value


class Option:
    """An option of a verb; its name is that of the parameter unless names are given."""

    def __init__(self, *names: str, help: str, callback: Callable[[Any], Any] | None = None, **attributes: Any) -> None:
        self.names, self.help, self.attributes = names, help, attributes
        if callback:
            self.attributes["callback"] = lambda context, parameter, value: callback(value)

    def parameter(self, name: str, kind: Any, default: Any) -> click.Parameter:
        """Return click's parameter: kind is the type, including a union with None or a list of many."""
        names = self.names or (f"--{name.replace('_', '-')}",)
        typed: dict[str, Any] = (
            {"is_flag": True} if kind is bool else {"type": _type(kind), **_many(kind, multiple=True)}
        )
        if default is Parameter.empty:
            typed["required"] = True
        else:
            typed |= {"default": default, "show_default": kind is not bool and default not in (None, "")}
        return click.Option([*names, name], help=self.help, **(typed | self.attributes))


class Argument(Option):
    """An argument of a verb, required unless it has a default."""

    def parameter(self, name: str, kind: Any, default: Any) -> click.Parameter:
        given = {} if default is Parameter.empty else {"default": default, "required": False}
        own = {"type": _type(kind), **_many(kind, nargs=-1)}
        return click.Argument([name], help=self.help, **own, **given, **self.attributes)


def _type(kind: Any) -> click.ParamType[Any, Any]:
    """Return the type of one value of ``X | None``, ``list[X]``, or ``Annotated[Any, read]``."""
    while get_origin(kind) in (list, UnionType, Union):
        kind = next(part for part in get_args(kind) if part is not type(None))
    return TYPES[kind] if kind in TYPES else Text(get_args(kind)[1])


def _many(kind: Any, **attributes: Any) -> dict[str, Any]:
    is_many = any(get_origin(part) is list for part in (kind, *get_args(kind)))
    return {**attributes, "callback": lambda context, parameter, values: list(values) or None} if is_many else {}


def command(function: Callable[..., Any], name: str | None, example: str) -> click.Command:
    """Return the verb of a function; a dataclass parameter becomes one option per field."""
    hints = get_type_hints(function, include_extras=True)
    groups = {own: hints[own] for own in signature(function).parameters if is_dataclass(hints[own])}

    def called(**given: Any) -> Any:
        made = {own: kind(**{one.name: given.pop(one.name) for one in fields(kind)}) for own, kind in groups.items()}
        return function(**given, **made)

    return click.Command(
        name or function.__name__.replace("_", "-"), callback=called, params=list(_parameters(function, hints)),
        help=function.__doc__, epilog=f"Example: {example}",
    )  # fmt: skip


def _parameters(function: Callable[..., Any], hints: dict[str, Any]) -> Iterator[click.Parameter]:
    for name, parameter in signature(function).parameters.items():
        if not is_dataclass(hints[name]):
            yield _declared(name, hints[name], parameter.default)
            continue
        kinds = get_type_hints(hints[name], include_extras=True)
        for one in fields(hints[name]):
            default = Parameter.empty if one.default is MISSING else one.default
            yield _declared(one.name, kinds[one.name], default)


def _declared(name: str, hint: Any, default: Any) -> click.Parameter:
    assert get_origin(hint) is Annotated, f"the parameter {name} of a verb is declared by no Option or Argument"
    kind, *read, declaration = get_args(hint)
    return declaration.parameter(name, Annotated[(kind, *read)] if read else kind, default)  # type: ignore[no-any-return]
