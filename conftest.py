"""README, docs and examples are tests: every Python block runs, every console command must do what its page shows."""

import fnmatch
import gc
import os
import re
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest
from _pytest import runner
from sybil import Sybil
from sybil.example import Example
from sybil.integration.pytest import SybilItem
from sybil.parsers.myst import CodeBlockParser, PythonCodeBlockParser

import console

UNMATCHED = pytest.StashKey[set[str]]()
PAGES = pytest.StashKey[dict[Any, list[Example]]]()


def pytest_configure(config: pytest.Config) -> None:
    """Compile once a run: one cache for all workers and for the commands they start, kept for the next run.

    One worker a core is enough: threads of a linear algebra library wait for each other, which takes time of the rest.
    """
    if "NARROWS_CACHE_DIR" not in os.environ:  # A run without pytest's own cache names the folder
        os.environ["NARROWS_CACHE_DIR"] = str(config.cache.mkdir("narrows"))
    os.environ.setdefault("SYMPY_CACHE_SIZE", "20000")  # Its own is too small for the systems of a run
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def pytest_collectstart(collector: pytest.Collector) -> None:
    """Collect tests without the garbage collector; a process that collects none keeps it."""
    gc.disable()


def pytest_collection_finish(session: pytest.Session) -> None:
    """Call the garbage collector, after the collection of tests, seldom: it takes a sixth of a compiler's time."""
    gc.collect()
    gc.freeze()
    gc.enable()
    gc.set_threshold(100_000, 20, 100)


def in_large_frame(function: Callable[..., Any], *arguments: Any) -> Any:
    """Call a function below a frame that makes Python take a piece of stack of a megabyte."""
    return function(*arguments)


# Python's stack comes in pieces of 16 kB. Where a loop calls across the end of one, each call maps and unmaps memory:
# a third of the time of Numba's compiler, at the depth that pytest calls tests from.
in_large_frame.__code__ = in_large_frame.__code__.replace(co_stacksize=1 << 16)


@pytest.hookimpl(trylast=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Run the blocks of a page that stand before this one."""
    if isinstance(item, SybilItem):
        for example in item.config.stash[PAGES][item.example.document]:
            if example.start < item.example.start:
                example.evaluate()


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item, nextitem: pytest.Item | None) -> object:
    """Run a test with its fixtures below the large frame."""
    return in_large_frame(runner.pytest_runtest_protocol, item, nextitem)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out tests that only the whole suite has; pages with consoles start processes and are slow tests."""
    mark_whole(config, items)
    if not os.environ.get("NARROWS_WHOLE"):
        config.hook.pytest_deselected(items=[item for item in items if item.get_closest_marker("whole")])
        items[:] = [item for item in items if not item.get_closest_marker("whole")]
    join_pages(config, items)


def join_pages(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Make a page one test, its last block: on two workers its blocks would run twice. The longest pages come first."""
    blocks = [item for item in items if isinstance(item, SybilItem)]
    config.stash[PAGES] = {}
    for block in blocks:
        config.stash[PAGES].setdefault(block.example.document, []).append(block.example)
    last = {block.example.document: block for block in blocks}
    for page, block in last.items():
        if any(example.region.evaluator is run_console for example in config.stash[PAGES][page]):
            block.add_marker(pytest.mark.slow)
    pages = sorted(last.values(), key=lambda block: -len(config.stash[PAGES][block.example.document]))
    items[:] = [*pages, *(item for item in items if not isinstance(item, SybilItem))]
    begin_apart(items)


# Two examples that compile the dearest loops, those of the filters and those of fleets.
COMPILING = ("shows[estimate_states]", "shows[ensemble]")


def begin_apart(items: list[pytest.Item]) -> None:
    """Let each half of the tests begin with other loops to compile: the other half then reads what was compiled."""
    dear = [item for name in COMPILING for item in items if item.name.endswith(name)]
    if len(dear) == len(COMPILING):
        items[:] = [dear[0], *(item for item in items if item not in dear)]
        items.insert((len(items) + 1) // 2, dear[1])


def mark_whole(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Mark what tests/whole.txt names, and note which of its patterns match no test."""
    lines = (Path(__file__).parent / "tests" / "whole.txt").read_text(encoding="utf-8").splitlines()
    patterns = {line: fnmatch.translate(line.replace("[", "[[]")) for line in lines if line and line[0] != "#"}
    unmatched, any_pattern = set(patterns), re.compile("|".join(patterns.values()))
    for item in items:
        name = whole_name(item)
        if any_pattern.match(name):
            item.add_marker(pytest.mark.whole)
            unmatched -= {line for line, pattern in patterns.items() if re.match(pattern, name)}
    is_complete = config.args == config.getini("testpaths")
    config.stash[UNMATCHED] = unmatched if is_complete else set()


def whole_name(item: pytest.Item) -> str:
    """Name of a test in tests/whole.txt: a block of a page by its first line, for line numbers change."""
    if not isinstance(item, SybilItem):
        return item.nodeid
    return f"{item.nodeid.partition('::')[0]}::{str(item.example.parsed).strip().partition(chr(10))[0]}"


@pytest.fixture
def unmatched_patterns(pytestconfig: pytest.Config) -> set[str]:
    """Patterns of tests/whole.txt that match no test, where all tests are collected."""
    return pytestconfig.stash[UNMATCHED]


def enter(namespace: dict[str, Any]) -> None:
    """Open a page in a folder of its own: what it writes is not written into the tree."""
    namespace["_folder"], namespace["_before"] = TemporaryDirectory(prefix="narrows-page-"), Path.cwd()
    console.fill(Path(namespace["_folder"].name))
    os.chdir(namespace["_folder"].name)


def leave(namespace: dict[str, Any]) -> None:
    """Go back, and remove the folder."""
    os.chdir(namespace["_before"])
    namespace["_folder"].cleanup()


def run_console(example: Example) -> None:
    """Run the commands of a block, those that are not marked as not run."""
    for command in filter(lambda command: command.runs, console.commands(example.parsed)):
        console.run(command, Path.cwd())


pytest_collect_file = Sybil(
    parsers=[PythonCodeBlockParser(), CodeBlockParser(language="console", evaluator=run_console)],
    patterns=["*.md"],
    excludes=["CHANGELOG.md"],
    setup=enter,
    teardown=leave,
).pytest()
