"""Docstrings of the public names agree with their signatures: each parameter, its unit, each refusal."""

import ast
import inspect
import re
import textwrap
from collections.abc import Iterator
from enum import Enum
from functools import cache
from pathlib import Path
from typing import Any

import docstring_parser

import narrows as nw
from narrows.quantities.names import MOTION, PARTICULARS

# The package ``nw.export`` is callable too, as its function ``write``.
PUBLIC = {name: own for name in nw.__all__ if callable(own := getattr(nw, name)) and not inspect.ismodule(own)}


def methods(name: str, thing: Any) -> Iterator[tuple[str, Any]]:
    """The public methods that a public class defines and does not inherit."""
    for own, method in vars(thing).items() if inspect.isclass(thing) else ():
        function = method.__func__ if isinstance(method, classmethod | staticmethod) else method
        inherited = any(getattr(getattr(base, own, None), "__doc__", None) for base in thing.__mro__[1:])
        if inspect.isfunction(function) and not own.startswith("_") and not inherited:
            yield f"{name}.{own}", function


DOCUMENTED = {place: own for name, thing in PUBLIC.items() for place, own in ((name, thing), *methods(name, thing))}


def has_own_signature(thing: Any) -> bool:
    """Whether there is something to document: exceptions, protocols, enumerations and heirs have no parameters."""
    if not inspect.isclass(thing):
        return True
    inherits = "__init__" not in vars(thing) and any("__init__" in vars(base) for base in thing.__mro__[1:-1])
    return not (inherits or issubclass(thing, Exception | Enum) or getattr(thing, "_is_protocol", False))


@cache
def parsed(thing: Any) -> docstring_parser.Docstring:
    return docstring_parser.parse(inspect.getdoc(thing) or "", docstring_parser.DocstringStyle.NUMPYDOC)


def at_fields(thing: Any) -> dict[str, str]:
    """The description of each field of a result, in a comment that Sphinx reads: before it or behind it."""
    kinds = reversed(thing.__mro__) if inspect.isclass(thing) else ()
    source = "".join(inspect.getsource(kind) for kind in kinds if kind.__module__.startswith("narrows"))
    found = re.findall(r"((?:^    #: .*\n)*)^    (\w+): [^#\n]*(?:#: (.*))?$", source, re.MULTILINE)
    # A section of a ship file describes its numbers where it defines them.
    numbers = re.findall(r'^    (\w+): \w+ = number_in\("(.*?)", "(.*?)"', source, re.MULTILINE)
    in_words = {name: before or behind for before, name, behind in found if before or behind}
    return in_words | {name: f"[{unit}] {meaning}" for name, unit, meaning in numbers}


@cache
def documented(thing: Any) -> dict[str, str]:
    """Each parameter of a docstring with its description; ``x, y`` are two."""
    return at_fields(thing) | {
        name.strip().lstrip("*"): f"{parameter.type_name} {parameter.description}"
        for parameter in parsed(thing).params
        if parameter.args[0] == "param"
        for name in parameter.arg_name.split(",")
    }


def parameters(thing: Any) -> dict[str, inspect.Parameter]:
    own = inspect.signature(thing).parameters
    return {name: parameter for name, parameter in own.items() if name not in ("self", "cls")}


WITH_PARAMETERS = {place: thing for place, thing in DOCUMENTED.items() if has_own_signature(thing)}


def test_every_public_name_has_a_docstring() -> None:
    assert [place for place, thing in DOCUMENTED.items() if len((thing.__doc__ or "").split()) < 2] == []


def in_sentences(place: str, thing: Any) -> bool:
    """Whether a method describes its parameters in sentences instead of sections."""
    return place not in PUBLIC and not parsed(thing).params


def test_parameters_are_those_of_the_signature() -> None:
    pairs = {
        place: (list(documented(thing)), list(parameters(thing)))
        for place, thing in WITH_PARAMETERS.items() if not in_sentences(place, thing)
    }  # fmt: skip
    assert {place: pair for place, pair in pairs.items() if pair[0] != pair[1]} == {}


def test_a_method_without_sections_names_each_parameter_in_its_sentences() -> None:
    methods = {place: thing for place, thing in WITH_PARAMETERS.items() if in_sentences(place, thing)}
    words = {place: set(re.findall(r"``(\w+)``", thing.__doc__)) for place, thing in methods.items()}
    assert [place for place, thing in methods.items() if not words[place] >= set(parameters(thing))] == []


def test_numbers_state_their_unit() -> None:
    missing = [
        f"{name}: {word}"
        for name, thing in WITH_PARAMETERS.items() if name in PUBLIC
        for word, parameter in parameters(thing).items()
        if (word in MOTION | PARTICULARS or parameter.annotation in (float, float | None))
        and "[" not in documented(thing)[word]
    ]  # fmt: skip
    assert missing == []


def test_physics_names_its_source() -> None:
    """Each function says what it gives with its unit, and where the formula is from."""
    folder = Path(nw.__path__[0]) / "physics"
    functions = [
        (f"{path.stem}.{node.name}", ast.get_docstring(node) or "")
        for path in folder.glob("*.py")
        for node in ast.parse(path.read_text(encoding="utf-8")).body
        if isinstance(node, ast.FunctionDef) and not node.name.startswith("_")
    ]
    assert len(functions) > 30
    assert [name for name, text in functions if "[" not in text.split("Source:")[0] or "Source:" not in text] == []


def test_an_editor_shows_what_holds() -> None:
    """No docstring, signature or field is made while the program runs."""
    tricks = re.compile(r"__signature__|object\.__setattr__|__doc__ =")
    made = [path for path in Path(nw.__path__[0]).rglob("*.py") if tricks.search(path.read_text(encoding="utf-8"))]
    # Verbs stand as written; what Typer reads of them is made of their groups of options.
    assert {path.name for path in made} - {"centreline.py", "options.py"} == set()


def refuses(thing: Any) -> bool:
    """Whether the code itself raises InputError, or calls a check that does; of a class, its check when made."""
    code = vars(thing).get("__post_init__") if inspect.isclass(thing) else thing
    if code is None:
        return False
    tree = ast.parse(textwrap.dedent(inspect.getsource(code)))
    raised = [node.exc for node in ast.walk(tree) if isinstance(node, ast.Raise) and node.exc is not None]
    called = [getattr(node.func, "id", "") for node in ast.walk(tree) if isinstance(node, ast.Call)]
    own = any(isinstance(error, ast.Call) and getattr(error.func, "id", "") == "InputError" for error in raised)
    return own or any(name.startswith("check_") for name in called)


def test_refusals_are_announced() -> None:
    assert refuses(nw.read_captive)
    assert not refuses(nw.Motion.at)
    silent = [place for place, thing in DOCUMENTED.items() if "InputError" not in (thing.__doc__ or "")]
    assert [place for place in silent if refuses(DOCUMENTED[place])] == []
