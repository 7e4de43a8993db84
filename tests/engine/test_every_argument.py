"""A differential test of every argument of every public function: changing it changes the answer, or is refused."""

import inspect
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from functools import cache
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from arguments import Entry, Other, Table

import narrows as nw

pytestmark = pytest.mark.usefixtures("one_tuning")


def functions() -> dict[str, Any]:
    """Every public function, by name."""
    found = {name: getattr(nw, name) for name in nw.__all__}
    return {name: own for name, own in found.items() if inspect.isfunction(own)}


def arguments() -> Iterator[tuple[str, str]]:
    """Every argument but those that stand for any name."""
    for name, function in functions().items():
        for argument in inspect.signature(function).parameters.values():
            if argument.kind is not argument.VAR_KEYWORD:
                yield name, argument.name


@pytest.fixture(scope="module")
def table(tmp_path_factory: pytest.TempPathFactory) -> Table:
    return Table(tmp_path_factory.mktemp("arguments"))


def plain(value: Any) -> Any:
    """A value as nested text and numbers, to compare."""
    if isinstance(value, xr.Dataset | xr.DataArray | pd.DataFrame):
        return plain(value.to_dict())
    if isinstance(value, np.ndarray):
        return [value.shape, value.tobytes() if value.dtype != object else list(value)]
    if isinstance(value, Mapping):
        return {str(key): plain(own) for key, own in value.items()}
    if isinstance(value, list | tuple):
        return [plain(own) for own in value]
    if is_dataclass(value) and not isinstance(value, type):
        return {own.name: plain(getattr(value, own.name)) for own in fields(value)}
    return repr(value)


def answer(name: str, entry: Entry, told: Mapping[str, Any]) -> Any:
    found = functions()[name](**told)
    return plain(entry.answer(found) if entry.answer else found)


@cache
def usual_answer(name: str, table: Table) -> Any:
    """Answer of the usual call, computed once for all arguments of a function."""
    return answer(name, table.entries[name], table.entries[name].usual)


def check(name: str, table: Table, argument: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Call with the usual value and with another."""
    entry = table.entries[name]
    other = entry.others[argument]
    other = other if isinstance(other, Other) else Other(other)
    told = {**entry.usual, **other.under}
    if "base" in told:
        told[argument] = told.pop("base")
    before = answer(name, entry, told) if other.under or other.shown else usual_answer(name, table)
    capsys.readouterr()
    if other.refused:
        with pytest.raises(nw.InputError):
            answer(name, entry, {**told, argument: other.value})
        return
    after = answer(name, entry, {**told, argument: other.value})
    assert capsys.readouterr().err if other.shown else before != after


@pytest.mark.parametrize(("name", "argument"), list(arguments()))
def test_another_value_gives_another_answer_or_is_refused(
    name: str, argument: str, table: Table, capsys: pytest.CaptureFixture[str]
) -> None:
    assert name in table.entries, f"{name} is public: give it an entry in arguments.py"
    entry = table.entries[name]
    assert argument in entry.others, f"{name}({argument}=...) is public: give it another value in arguments.py"
    check(name, table, argument, capsys)


def test_names_that_are_varied_count_too(table: Table, capsys: pytest.CaptureFixture[str]) -> None:
    """Arguments by any name: those that the table gives."""
    silent = []
    for name, entry in table.entries.items():
        own = inspect.signature(functions()[name]).parameters
        for argument in entry.others if any(one.kind is one.VAR_KEYWORD for one in own.values()) else ():
            if argument not in own:
                try:
                    check(name, table, argument, capsys)
                except (AssertionError, pytest.fail.Exception, nw.InputError) as error:
                    silent.append(f"{name}({argument}=...): {error}")
    assert not silent


def test_the_table_names_nothing_that_is_gone(table: Table) -> None:
    gone = [name for name in table.entries if name not in functions()]
    for name in set(table.entries) - set(gone):
        own = inspect.signature(functions()[name]).parameters
        if not any(one.kind is one.VAR_KEYWORD for one in own.values()):
            gone += [f"{name}({argument})" for argument in table.entries[name].others if argument not in own]
    assert not gone
