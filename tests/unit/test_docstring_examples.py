"""The examples in the docstrings of public names run, and print what they show."""

import doctest
import inspect
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import narrows as nw

PUBLIC = {name: own for name in sorted(nw.__all__) if callable(own := getattr(nw, name)) and not inspect.ismodule(own)}
WITH_EXAMPLE = [name for name, thing in PUBLIC.items() if ">>>" in (inspect.getdoc(thing) or "")]
# Public names without an example.
MOST_WITHOUT = 46


CONDITIONS = nw.measured_tests("kcs").by_condition()
# An example that shows another condition than most.
OTHER_TESTS = {"identify_conditions": {"tests": CONDITIONS["C0101A01"]}}


@pytest.fixture(scope="module")
def names() -> dict[str, Any]:
    """What the examples share: a model with banks, a ready ship at full size, measured tests and their fit."""
    tests = CONDITIONS["C0101A03"]  # Fitted quickest
    models = {"model": nw.published("mikkelsen2025_dtc"), "kcs": nw.published("estimated_kcs")}
    return {"nw": nw, "np": np, "tests": tests, "fit": nw.identify(tests), **models}


@pytest.fixture
def folder(tmp_path: Path) -> Iterator[Path]:
    before = Path.cwd()
    os.chdir(tmp_path)
    yield tmp_path
    os.chdir(before)


@pytest.mark.parametrize("name", WITH_EXAMPLE)
@pytest.mark.usefixtures("folder")
def test_an_example_prints_what_it_shows(name: str, names: dict[str, Any]) -> None:
    text = inspect.getdoc(PUBLIC[name]) or ""
    example = doctest.DocTestParser().get_doctest(text, names | OTHER_TESTS.get(name, {}), name, None, None)
    report: list[str] = []
    failed, tried = doctest.DocTestRunner(verbose=False).run(example, out=report.append)
    assert tried > 0
    assert failed == 0, "".join(report)


def test_most_public_names_have_an_example() -> None:
    without = sorted(set(PUBLIC) - set(WITH_EXAMPLE))
    assert len(without) <= MOST_WITHOUT, without


def test_tutorials_import_public_names_only() -> None:
    pages = (Path(__file__).parents[2] / "docs" / "tutorials").glob("*.md")
    internal = re.compile(r"^\s*(?:from|import) narrows\.\w+\.?\S*", re.MULTILINE)
    assert {page.name: found for page in pages if (found := internal.findall(page.read_text(encoding="utf-8")))} == {}
