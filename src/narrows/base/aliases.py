"""Names of pandas, SciPy, statsmodels, python-control and other simulators, and the names here: ``aliases.toml``."""

import inspect
import re
import tomllib
from collections.abc import Callable, Iterable
from functools import cache, wraps
from importlib import import_module
from operator import attrgetter
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from narrows.base.errors import InputError, near_miss, shown

CANAL = {"width", "depth"}
# Functions that read the file of an argument.
READERS = {"waterway": "read_waterway", "model": "load_model", "truth": "load_model"}
Function = TypeVar("Function", bound=Callable[..., Any])


@cache
def _tables() -> dict[str, dict[str, list[str]]]:
    return tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))


def aliases(kind: str) -> dict[str, list[str]]:
    """Return the names of other libraries by the names here, of attributes, arguments, functions ..."""
    return _tables()[kind]


def name_here(name: str, kind: str, fits: Callable[[str], bool] = lambda ours: True) -> str | None:
    """Return the first fitting name here of another library's name."""
    return next((ours for ours, theirs in aliases(kind).items() if name in theirs and fits(ours)), None)


def names_of(kind: Any) -> set[str]:
    """Return the attributes of a class, and its fields without a default."""
    return {*dir(kind), *getattr(kind, "__dataclass_fields__", ())}


def function_named(name: str) -> Any:
    """Return the public function of another library's name, also one for a part of a result; None if there is none."""
    import narrows

    if ours := name_here(name, "functions"):
        return attrgetter(ours)(narrows)
    row = name_here(name, "results")
    return _part_of(*row.rsplit(".", 1)) if row else None


def _part_of(path: str, part: str) -> Any:
    """Return the function for a part of another one's result: ``nw.bootstrap`` for ``identify(tests).bootstrap``."""
    import narrows

    function = attrgetter(path)(narrows)
    arguments = Arguments(function)

    @wraps(function)
    def called(*values: Any, **given: Any) -> Any:
        if values and part in names_of(type(values[0])):
            made, rest = values[0], given
        else:
            rest = {name: value for name, value in given.items() if not arguments.has(name)}
            made = function(*values, **{name: value for name, value in given.items() if name not in rest})
        found = getattr(made, part)
        if rest and not inspect.isroutine(found):
            raise InputError(f"{part} takes no {', '.join(rest)}; write {path}(...).{part}")
        return found(**rest) if inspect.isroutine(found) else found

    return called


def part_named(name: str, room: str, parts: Iterable[str]) -> Any:
    """Return a part of a subpackage by another library's name; raise if there is none."""
    import narrows

    if same := name_here(name, "parts", frozenset(parts).__contains__):
        return getattr(getattr(narrows, room), same)
    meant = name_here(name, room) or (hasattr(narrows, name) and f"nw.{name}") or _instead_of(name)
    raise AttributeError(f"nw.{room} has no {name!r}" + (f"; write {meant}" if meant else near_miss(name, parts)))


def public_name(name: str, known: Iterable[str]) -> str:
    """Return what to write instead of an unknown public name, as the end of a sentence."""
    longer = [word for word in sorted(known) if len(name) > 2 and name.lower() in word.lower()]
    if reason := name_here(name, "why"):
        return f": {reason}"
    meant = _instead_of(name) or " or ".join(longer)
    return f"; write {meant}" if meant else near_miss(name, known, cutoff=0.75)


def _instead_of(name: str) -> str:
    """Return what to write instead of a name, or which results have it: ``.predict of a Fit``."""
    import narrows

    if meant := name_here(name, "other_functions"):
        return meant
    found = []
    for kind in () if name.startswith("_") else aliases("first"):
        parts = names_of(attrgetter(kind)(narrows))
        rows = [ours for ours, theirs in aliases("attributes").items() if name in theirs or f"{name}()" in theirs]
        if name in parts or any(re.split(r"[(.]", row)[0] in parts for row in rows):
            found.append(kind.rpartition(".")[2])
    return f".{name} of a {' or '.join(found[:3])}" if found else ""


def accept_aliases(function: Function) -> Function:
    """Accept the other names of a function's arguments, or of a class's fields; for a model, what has one."""
    if isinstance(function, type):
        function.__init__ = accept_aliases(function.__init__)  # type: ignore[misc]
        return function
    arguments = Arguments(function)
    names = [*arguments.parameters]

    @wraps(function)
    def called(*values: Any, **given: Any) -> Any:
        if callable(given.get("rudder")) and "controller" in names:
            law = given.pop("rudder")
            of_time = inspect.isfunction(law) and len(inspect.signature(law).parameters) == 1
            given["controller"] = (lambda t, state: law(t)) if of_time else law
        canal = {ours: given.pop(name) for name in [*given] if (ours := arguments.of_canal(name, given))}
        given = arguments.renamed(_with_parts(arguments.parameters, names[len(values) :], given))
        values = (*map(arguments.converted, names, values), *values[len(names) :])
        given = {name: arguments.converted(name, value) for name, value in given.items()}
        if canal and values:
            values = (values[0].with_canal(**canal), *values[1:])
        elif canal and given.get("model"):
            given["model"] = given["model"].with_canal(**canal)
        try:
            return function(*values, **given)
        except TypeError:
            _check_fits(arguments.own, function, values, given)
            raise

    return called  # type: ignore[return-value]


class Arguments:
    """The arguments of a function under their other names, and their values with units."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self.parameters = inspect.signature(function).parameters
        self.own = function.__qualname__.removesuffix(".__init__").rpartition(".")[2]
        # A model that heads the arguments, of a method or an ``__init__`` after the object.
        first = next((name for name in self.parameters if name != "self"), "")
        self.model = "self" if function.__qualname__.startswith("Model.") else "model" if first == "model" else ""
        self.more = next((own.name for own in self.parameters.values() if own.kind is own.VAR_KEYWORD), "")

    def renamed(self, given: dict[str, Any]) -> dict[str, Any]:
        """Return named arguments by the names here; raise where a name is answered with what to write."""
        if "rpm" in given and self._takes("revolutions"):
            given["revolutions_rpm"] = given.pop("rpm")
        for name in [name for name in given if name not in self.parameters]:
            if self.more == "style" or (self.more and name in aliases("arguments")):
                continue
            ours = self._name_here(name)
            if not ours and (stem := self._without_unit(name)) and (size := unit_of(name, stem)):
                ours, value = stem, given[name]
                given[name] = value if isinstance(value, str | None) else np.multiply(size, value)
            if ours and ours not in given:
                given[ours] = given.pop(name)
            elif ours:
                raise InputError(f"{name} and {ours} are one argument; give {ours}")
            elif meant := name_here(name, "other_arguments", self._are_own):
                if "95 %" in meant and given[name] in (0.05, 0.95):
                    del given[name]
                    continue
                raise InputError(f"{self.own} has no argument {name!r}; write {meant}")
        return given

    def of_canal(self, name: str, given: dict[str, Any]) -> str | None:
        """Return ``width`` or ``depth`` if a name is that of the canal in which the function's model then runs."""
        # A fleet varies them itself, and a waterway has its own.
        in_canal = self.model and self.more in ("", "positions") and given.get("waterway") is None
        if not in_canal or self._name_here(name):
            return None
        ours = name if name in CANAL else name_here(name, "arguments", CANAL.__contains__)
        return ours if ours not in self.parameters and name not in self.parameters else None

    def converted(self, name: str, value: Any) -> Any:
        """Return the model of a fit or file, and a number that is written with its unit in SI, or degrees."""
        if name == self.model:
            return _model_of(value)
        if name in READERS and isinstance(value, str | Path):
            return attrgetter(READERS[name])(import_module("narrows"))(value)
        if not isinstance(value, str) or name not in (*aliases("arguments"), "speed", "heading"):
            return value
        names = import_module("narrows.quantities.names")
        number = names.in_si(value, name)
        in_degrees = f"{self.own}.{name}" in aliases("own_arguments") and number != value
        return number / names.DEGREE if in_degrees else number

    def has(self, name: str) -> bool:
        return bool(name in self.parameters or self.more or self._name_here(name) or self._without_unit(name))

    def _name_here(self, name: str) -> str:
        # A name can be that of two arguments (h: a step or a depth): the function has one of them.
        ours = name_here(name, "own_arguments", lambda row: row.startswith(f"{self.own}."))
        ours = ours or name_here(name, "arguments", self._takes)
        return (ours or name_here(name, "objects", self.parameters.__contains__) or "").rpartition(".")[2]

    def _takes(self, ours: str) -> bool:
        # A fleet varies any quantity; positions are those of actuators alone.
        return ours in self.parameters or (
            bool(self.more) and (self.more != "positions" or ours in ("rudder", "revolutions"))
        )

    def _are_own(self, row: str) -> bool:
        named = set(re.findall(r"\b(\w+)=", row))
        return named <= self.parameters.keys() | (aliases("arguments").keys() if self.more else set())

    def _without_unit(self, name: str) -> str:
        stem = name.rpartition("_")[0]
        is_own = stem in self.parameters or (stem in aliases("arguments") and self._takes(stem))
        ours = stem if is_own else self._name_here(stem)
        return "" if f"{self.own}.{ours}" in aliases("own_arguments") else ours  # These are not in SI


def unit_of(name: str, ours: str) -> float | None:
    """Return the unit at the end of a name, such as ``speed_knots``, of an argument or attribute [SI]."""
    unit: float | None = import_module("narrows.quantities.names").unit_at_end(name, ours)
    return unit


def _with_parts(parameters: Any, free: list[str], given: dict[str, Any]) -> dict[str, Any]:
    """Return arguments with a ship and a canal made of their dimensions, where a function takes those parts."""
    if not given.keys() - parameters.keys():
        return given
    import narrows

    parts, rest = {"ship": narrows.Ship, "canal": narrows.Canal}, dict(given)
    # Both parts in one argument, unless that is given.
    whole = next((name for name in free if "Configuration" in str(parameters[name].annotation)), "")
    whole = whole if isinstance(given.get(whole, narrows.Ship), narrows.Ship | type) else ""
    for part, kind in parts.items():
        if (part in free and part not in given) or (whole and part not in parameters.keys() - {whole}):
            fields = kind.__dataclass_fields__.keys() - parameters.keys()
            here = {
                name: name if name in fields else name_here(name, "arguments", fields.__contains__) for name in rest
            }
            if sizes := {ours: rest.pop(name) for name, ours in here.items() if ours}:
                rest[part] = kind(**sizes) if whole or "Mapping" not in str(parameters[part].annotation) else sizes
    if whole and {"ship", "canal"} <= rest.keys():
        rest[whole] = narrows.Configuration(rest.pop("ship"), rest.pop("canal"))
    return rest


def _check_fits(own: str, function: Callable[..., Any], values: Any, given: Any) -> None:
    """Raise if arguments do not fit a function, with its arguments, or for a class what makes its objects."""
    signature = inspect.signature(function)
    try:
        signature.bind(*values, **given)
    except TypeError as error:
        made_by = name_here(own, "made_by")
        fitting = ", ".join(name for name in signature.parameters if name != "self")
        named = "; give them by name" * ("positional" in str(error))
        remedy = f"{made_by} makes one" if made_by else f"its arguments: {fitting}{named}"
        raise InputError(f"{own}: {error}; {remedy}") from None


def _model_of(given: Any) -> Any:
    """Return a model: the one of a fit or of another result, or that of a file or a published name."""
    import narrows

    if isinstance(given, str | Path):
        return narrows.load_model(given)
    if isinstance(given, narrows.Model):
        return given
    if "model" in names_of(type(given)):
        return given.model
    if type(given).__name__ == "DataFrame":
        raise InputError("a table of coefficients is no model; write ensemble(model, samples=100), which draws them")
    raise InputError(f"{shown(given)} is no model; give nw.published(name), nw.load_model(path) or the model of a fit")
