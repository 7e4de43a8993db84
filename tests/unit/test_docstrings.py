"""Docstrings agree with signatures: every name said, every quantity with its unit, every refusal announced."""

import ast
import importlib
import inspect
import pkgutil
import re
import textwrap
from collections.abc import Iterator
from enum import Enum
from pathlib import Path
from typing import Any

import docstring_parser
import pytest

import narrows as nw
from narrows.quantities.names import MOTION, PARTICULARS, REGRESSOR_INPUTS
from narrows.ship.actuators import STANDARD

VOCABULARY = {**REGRESSOR_INPUTS, **{word: said for own in STANDARD for word, said in own.quantities.items()}}
NEVER_IMPORTED = tuple(f"narrows.codegen.kernels.{name}" for name in ("queue", "newton", "sensitivity"))
"""Source text that goes into compiled programs."""
SPOKEN_OF_ELSEWHERE = ("narrows.cli", "narrows.codegen")
"""Options of the command line say what they are in --help; the compiler's inner parts speak to each other."""


def members(module: Any) -> Iterator[tuple[str, Any]]:
    """Every public function, class and method that a module defines."""
    for name, thing in vars(module).items():
        if name.startswith("_") or getattr(thing, "__module__", None) != module.__name__:
            continue
        if inspect.isfunction(thing) or inspect.isclass(thing):
            yield f"{module.__name__}.{name}", thing
        if inspect.isclass(thing):
            for own, method in vars(thing).items():
                function = method.__func__ if isinstance(method, classmethod | staticmethod) else method
                inherited = any(getattr(getattr(base, own, None), "__doc__", None) for base in thing.__mro__[1:])
                if inspect.isfunction(function) and not own.startswith("_") and not inherited:
                    yield f"{module.__name__}.{name}.{own}", function


def everything() -> Iterator[tuple[str, Any]]:
    for info in pkgutil.walk_packages(nw.__path__, "narrows."):
        if info.name not in NEVER_IMPORTED:
            yield from members(importlib.import_module(info.name))


PUBLIC = dict(everything())
SPOKEN = {place: thing for place, thing in PUBLIC.items() if not place.startswith(SPOKEN_OF_ELSEWHERE)}
EXPORTED = {name: getattr(nw, name) for name in nw.__all__ if callable(getattr(nw, name))}


def has_own_signature(thing: Any) -> bool:
    """Whether there is something to document: exceptions, protocols, enumerations and heirs have no parameters."""
    if not inspect.isclass(thing):
        return True
    inherits = "__init__" not in vars(thing) and any("__init__" in vars(base) for base in thing.__mro__[1:-1])
    return not (inherits or issubclass(thing, Exception | Enum) or getattr(thing, "_is_protocol", False))


def parsed(thing: Any) -> docstring_parser.Docstring:
    return docstring_parser.parse(inspect.getdoc(thing) or "", docstring_parser.DocstringStyle.NUMPYDOC)


def documented(thing: Any) -> dict[str, str]:
    """Each parameter of a docstring with what is said of it; ``x, y`` are two."""
    return {
        name.strip().lstrip("*"): f"{parameter.type_name} {parameter.description}"
        for parameter in parsed(thing).params
        if parameter.args[0] == "param"
        for name in parameter.arg_name.split(",")
    }


def asked(thing: Any) -> dict[str, inspect.Parameter]:
    """Each parameter of a signature."""
    parameters = inspect.signature(thing).parameters
    return {name: parameter for name, parameter in parameters.items() if name not in ("self", "cls")}


@pytest.mark.parametrize("place", sorted(PUBLIC))
def test_has_a_docstring(place: str) -> None:
    assert len((PUBLIC[place].__doc__ or "").split()) >= 2


@pytest.mark.parametrize("place", sorted(place for place, thing in SPOKEN.items() if has_own_signature(thing)))
def test_parameters_are_those_of_the_signature(place: str) -> None:
    assert list(documented(SPOKEN[place])) == list(asked(SPOKEN[place]))


@pytest.mark.parametrize("name", sorted(name for name in EXPORTED if has_own_signature(EXPORTED[name])))
def test_exported_numbers_state_their_unit(name: str) -> None:
    said = documented(EXPORTED[name])
    for word, parameter in asked(EXPORTED[name]).items():
        if word in MOTION | PARTICULARS or parameter.annotation in (float, float | None):
            assert "[" in said[word], f"{word} states no unit"


@pytest.mark.parametrize(
    "place", sorted(p for p, thing in SPOKEN.items() if ".physics." in p and not inspect.isclass(thing))
)
def test_physics_states_units_and_source(place: str) -> None:
    said = documented(SPOKEN[place])
    assert said
    assert all("[" in text for text in said.values())
    units = {name: VOCABULARY[name].unit for name in said if name in VOCABULARY}
    assert {name: said[name].partition("[")[2].partition("]")[0] for name in units} == units
    assert "Source:" in SPOKEN[place].__doc__
    assert "[" in SPOKEN[place].__doc__.split("Source:")[0], "the result states no unit"


def test_what_an_editor_shows_is_what_holds() -> None:
    """No docstring, signature or field is made while the program runs."""
    tricks = re.compile(r"__signature__|object\.__setattr__|__doc__ =")
    made = [path for path in Path(nw.__path__[0]).rglob("*.py") if tricks.search(path.read_text(encoding="utf-8"))]
    # Verbs stand as written; what Typer reads of them is made of their groups of options.
    assert {path.name for path in made} - {"centreline.py", "grouped.py"} == set()


def refuses(thing: Any) -> bool:
    """Whether the code itself raises InputError, or calls a check that does; of a class, its check when made."""
    code = vars(thing).get("__post_init__") if inspect.isclass(thing) else thing
    if code is None:
        return False
    tree = ast.parse(textwrap.dedent(inspect.getsource(code)))
    raised = [node.exc for node in ast.walk(tree) if isinstance(node, ast.Raise) and node.exc is not None]
    called = [getattr(node.func, "id", "") for node in ast.walk(tree) if isinstance(node, ast.Call)]
    said = any(isinstance(own, ast.Call) and getattr(own.func, "id", "") == "InputError" for own in raised)
    return said or any(name.startswith("check_") for name in called)


def test_some_code_refuses() -> None:
    """The look into the source finds what it should."""
    assert refuses(nw.read_captive)
    assert refuses(nw.Configuration)
    assert not refuses(nw.Motion.at)


@pytest.mark.parametrize("place", sorted(place for place, thing in SPOKEN.items() if refuses(thing)))
def test_refusals_are_announced(place: str) -> None:
    assert "InputError" in [own.type_name for own in parsed(SPOKEN[place]).raises]
