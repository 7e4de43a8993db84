"""Mutations: small errors put into the code one at a time, to see that a test fails for each.

Each mutation changes one operator, comparison or number of a file. The tests that run the changed line, as coverage.py
recorded them, then run until the first failure, the quickest first. What no test notices is printed as a survivor, with
its line before and after. Record first which test runs which line, with pytest-cov (a quarter of an hour):

    python -m pip install pytest-cov
    python -m pytest -n auto --cov=narrows --cov-context=test --cov-report= --junitxml=out/tests.xml tests
    python decisions/mutations.py                     # 100 mutations, the same at every run
    python decisions/mutations.py --count 20 --seed 3 --of warning
"""

import argparse
import ast
import copy
import io
import os
import random
import re
import shutil
import signal
import sys
import tempfile
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from xml.etree import ElementTree

from coverage import CoverageData

ROOT = Path(__file__).parents[1]
PACKAGES = [
    "estimation", "control", "warning", "safety", "logbook",
    "identification/least_squares.py", "identification/mixed_model.py",
]  # fmt: skip
TESTING_TIME = 120  # [s], of the tests that run for one mutation when none of them fails
TIME_LIMIT = 300  # [s], after which a mutation counts as noticed: it made something endless
ROUNDING = 1e-6  # a smaller number guards against rounding: twice as much is as good
SWAPS: dict[type, type] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Lt: ast.GtE, ast.GtE: ast.Lt,
    ast.Gt: ast.LtE, ast.LtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip
# Functions that only word or draw a result, and arguments of caches and iterations: another number there is no error.
WORDING = re.compile(r"summary|notes|words|describe.*|_?(plot|draw|print).*|__(repr|str)__")
OF_NO_CLAIM = re.compile(r"maxsize|maxiter|ftol|xtol|rtol|atol|figsize|dpi|digits|seed")
# Constants that bound memory, waiting and rounding: twice the number is as good.
BOUNDS = re.compile(
    r"MOST_\w+|LONGEST_\w+|DIGITS|SAME\w*|\w+_(QUEUE|TIMEOUT|INTERVAL|PAUSE|RETRY|TOLERANCE)|\w*BLOCK|STEPS\w*"
)


@dataclass(frozen=True)
class Mutation:
    """One changed place of one file."""

    path: Path  # of the file, relative to the package
    line: int
    end: int  # its last line
    place: int  # of the node among those of the file that can be changed
    before: str
    after: str

    def __str__(self) -> str:
        return f"{self.path}:{self.line}: {self.before}  ->  {self.after}"


def changed(node: ast.AST) -> ast.AST | None:
    """A copy of a node with one error in it, or None where it offers none."""
    new = copy.copy(node)
    if isinstance(node, ast.BinOp | ast.BoolOp) and type(node.op) in SWAPS:
        new.op = SWAPS[type(node.op)]()
    elif isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in SWAPS:
        new.ops = [SWAPS[type(node.ops[0])]()]
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub) and not isinstance(node.operand, ast.Constant):
        return node.operand
    elif isinstance(node, ast.Constant) and type(node.value) in (int, float) and not 0 < node.value <= ROUNDING:
        new.value = node.value * 2 if node.value else 1
    else:
        return None
    return new


def is_left_out(node: ast.AST) -> bool:
    """Whether a part of a file holds no claim: messages, wording, drawing, bounds."""
    if isinstance(node, ast.Raise | ast.JoinedStr):
        return True
    if isinstance(node, ast.FunctionDef):
        return WORDING.fullmatch(node.name) is not None
    if isinstance(node, ast.keyword):
        return node.arg is not None and OF_NO_CLAIM.fullmatch(node.arg) is not None
    if isinstance(node, ast.Assign):
        names = [name.id for target in node.targets for name in ast.walk(target) if isinstance(name, ast.Name)]
        return bool(names) and all(BOUNDS.fullmatch(name) for name in names)
    return False


def is_reshape(node: ast.AST) -> bool:
    """Whether a node calls ``reshape``, for which every negative size is the one that follows from the others."""
    return isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "reshape"


def places(node: ast.AST) -> Iterator[tuple[ast.AST, str, int]]:
    """Each node that can be changed, as its parent, the field and the index in it (-1: the field itself)."""
    for field, value in ast.iter_fields(node):
        if field in ("annotation", "returns", "decorator_list"):
            continue
        for index, child in enumerate(value if isinstance(value, list) else [value]):
            if (
                not isinstance(child, ast.AST)
                or is_left_out(child)
                or (is_reshape(node) and isinstance(child, ast.UnaryOp))
            ):
                continue
            # A bare index is a name of a place and no arithmetic.
            named = isinstance(node, ast.Subscript) and isinstance(child, ast.Constant)
            if isinstance(child, ast.expr) and not named and changed(child) is not None:
                yield node, field, index if isinstance(value, list) else -1
            yield from places(child)


def text_of(path: Path) -> str:
    """The source of a file of the package, empty where it is gone since the tests were recorded."""
    file = ROOT / "src/narrows" / path
    return file.read_text("utf-8") if file.exists() else ""


def mutations(path: Path) -> list[Mutation]:
    """All mutations of a file."""
    found = []
    for place, (parent, field, index) in enumerate(places(ast.parse(text_of(path)))):
        value = getattr(parent, field)
        node = value if index < 0 else value[index]
        before, after = ast.unparse(node), ast.unparse(changed(node))
        found.append(Mutation(path, node.lineno, node.end_lineno, place, before, after))
    return found


def mutated(mutation: Mutation) -> str:
    """The text of the file with its error in it."""
    tree = ast.parse(text_of(mutation.path))
    parent, field, index = list(places(tree))[mutation.place]
    if index < 0:
        setattr(parent, field, changed(getattr(parent, field)))
    else:
        getattr(parent, field)[index] = changed(getattr(parent, field)[index])
    return ast.unparse(tree)


def drawn(count: int, seed: int, package: str | None) -> list[Mutation]:
    """Mutations spread evenly over the packages, drawn by chance."""
    draw, packages = random.Random(seed), [package] if package else PACKAGES
    chosen = []
    for number, name in enumerate(packages):
        place = ROOT / "src/narrows" / name
        files = [place] if place.is_file() else sorted(place.rglob("*.py"))
        every = [m for path in files for m in mutations(path.relative_to(ROOT / "src/narrows"))]
        share = count // len(packages) + (number < count % len(packages))
        chosen += draw.sample(every, min(share, len(every)))
    return chosen


def assigned_at(mutation: Mutation) -> list[str]:
    """The names that the statement of a mutation assigns, outside functions."""
    top = ast.parse(text_of(mutation.path)).body
    for node in [*top, *(inner for kind in top if isinstance(kind, ast.ClassDef) for inner in kind.body)]:
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.lineno <= mutation.line <= node.end_lineno:
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            return [name.id for target in targets for name in ast.walk(target) if isinstance(name, ast.Name)]
    return []


def tests_naming(word: re.Pattern[str]) -> Iterator[str]:
    """The tests in whose text a name stands: they may run no line that has it."""
    for path in sorted((ROOT / "tests").rglob("test_*.py")):
        if word.search(text := path.read_text("utf-8")):
            for node in ast.parse(text).body:
                named = isinstance(node, ast.FunctionDef) and node.name.startswith("test_")
                if named and word.search(ast.get_source_segment(text, node) or ""):
                    yield f"{path.relative_to(ROOT).as_posix()}::{node.name}"


def tests_importing(mutation: Mutation) -> Iterator[str]:
    """The tests of the files that name the module of a mutation and its function: lines of import and compiled ones.

    Which test runs those is not recorded.
    """
    top = ast.parse(text_of(mutation.path)).body
    inside = [node for node in top if node.lineno <= mutation.line <= node.end_lineno]
    if any(isinstance(node, ast.ClassDef) for node in inside):
        return
    package = ".".join(["narrows", *mutation.path.parts[:-1]])
    names = [package, mutation.path.stem, *(node.name for node in inside if isinstance(node, ast.FunctionDef))]
    for path in sorted((ROOT / "tests").rglob("test_*.py")):
        text = path.read_text("utf-8")
        if all(re.search(rf"\b{name}\b", text) for name in names):
            tests = [n.name for n in ast.parse(text).body if isinstance(n, ast.FunctionDef)]
            yield from (f"{path.relative_to(ROOT).as_posix()}::{name}" for name in tests if name.startswith("test_"))


class Coverage:
    """The tests that ran each line of the package, with their times."""

    def __init__(self, data: Path, times: Path) -> None:
        self.data = CoverageData(str(data))
        self.data.read()
        self.files = {name.rpartition("/narrows/")[2]: name for name in self.data.measured_files()}
        self.times: dict[str, float] = {}
        for case in ElementTree.parse(times).iter("testcase"):
            name = f"{case.get('classname')}.{case.get('name')}".replace(".", "/")
            self.times[name] = self.times.get(name, 0.0) + float(case.get("time") or 0)

    def tests_of(self, mutation: Mutation) -> list[str]:
        """Tests of the mutated lines, the quickest first.

        With those of the files that name its module and function. Where the lines run at import: of the lines that
        have the assigned name, and those that name it, else of the file. Where they are compiled: of the files that
        import it.
        """
        by_line, names = self._tests(mutation.path), assigned_at(mutation)
        ran = {test for line in range(mutation.line, mutation.end + 1) for test in by_line.get(line, ())}
        here = ran | set(tests_importing(mutation))
        if names and not ran:
            word = re.compile(rf"\b({'|'.join(names)})\b")
            here |= {test for path in map(Path, self.files) for test in self._tests_with(word, path)} | set(
                tests_naming(word)
            )
        here = here or {test for tests in by_line.values() for test in tests}
        if not here:
            named = re.compile(rf"import .*\b{mutation.path.stem}\b|\.{mutation.path.stem} import")
            users = [path for path in map(Path, self.files) if named.search(text_of(path))]
            here = {test for path in users for tests in self._tests(path).values() for test in tests}
        chosen, left = [], float(TESTING_TIME)
        for test in sorted(here, key=self.time_of):
            left -= self.time_of(test)
            if left < 0 and chosen:
                break
            chosen.append(test)
        return chosen

    def time_of(self, test: str) -> float:
        """Time of a test [s]."""
        path, _, name = test.partition("::")
        return self.times.get(f"{path.removesuffix('.py')}/{name}".replace("::", "/").replace(".", "/"), 1.0)

    def _tests_with(self, word: re.Pattern[str], path: Path) -> Iterator[str]:
        if word.search(text := text_of(path)):
            by_line = self._tests(path)
            for number, line in enumerate(text.splitlines(), 1):
                if word.search(line):
                    yield from by_line.get(number, ())

    def _tests(self, path: Path) -> dict[int, list[str]]:
        by_line = self.data.contexts_by_lineno(self.files.get(path.as_posix(), ""))
        # pytest-cov names the phase of a test behind a bar; at import there is no test
        return {line: [name for each in found if (name := each.rpartition("|")[0])] for line, found in by_line.items()}


def is_noticed(mutation: Mutation, tests: list[str], source: Path) -> bool:
    """Run tests on a copy of the package that has an error in it, and the one that fails without the error too."""
    file = source / "narrows" / mutation.path
    whole = file.read_text("utf-8")
    while tests:
        file.write_text(mutated(mutation), "utf-8")
        failing = first_failure(tests, source)
        file.write_text(whole, "utf-8")
        shutil.rmtree(source / "cache", ignore_errors=True)
        if not failing or failing not in tests or not first_failure([failing], source):
            return bool(failing)
        tests = [test for test in tests if test != failing]
    return False


def first_failure(tests: list[str], source: Path) -> str:
    """The first test that fails ("": none), in a process of its own, which shares the libraries that are loaded."""
    said, saying = os.pipe()
    child = os.fork()
    if not child:
        try:
            run_tests(tests, source, saying)
        finally:
            os._exit(0)
    os.waitpid(child, 0)
    os.write(saying, b"\n")
    answer = os.read(said, 10_000).decode()
    os.close(saying)
    os.close(said)
    if answer.startswith("?"):
        whole = sorted({test.partition("[")[0] for test in tests})
        if whole == sorted(tests):
            raise SystemExit(f"pytest does not run {' '.join(tests)}")
        return first_failure(whole, source)  # The error is in the names of cases
    # One empty line is written by this process alone: the other was killed, after TIME_LIMIT or by what it ran
    return "no end" if answer == "\n" else answer.partition("\n")[0]


def run_tests(tests: list[str], source: Path, answer: int) -> None:
    """Write the first test that fails, or what cannot be collected, then an empty line, or ? where no test runs."""
    import pytest

    class Failures:
        def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
            if report.failed:
                os.write(answer, f"{report.nodeid}\n".encode())

        def pytest_collectreport(self, report: pytest.CollectReport) -> None:
            if report.failed:
                os.write(answer, f"{report.nodeid}\n".encode())

    signal.alarm(TIME_LIMIT)
    os.environ["PYTHONPATH"] = str(source)
    os.environ["NARROWS_CACHE_DIR"] = str(source / "cache")  # Programs of a mutated generator must not outlive it
    sys.path.insert(0, str(source))
    sys.dont_write_bytecode = True
    os.chdir(ROOT)
    with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
        code = pytest.main(["-x", "-q", "-p", "no:xdist", *tests], plugins=[Failures()])
    os.write(answer, b"?\n" if code > pytest.ExitCode.INTERRUPTED else b"\n")


def main() -> None:
    """Make the mutations and print the survivors."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--count", type=int, default=100, help="how many mutations")
    options.add_argument("--seed", type=int, default=0, help="of the choice")
    options.add_argument("--of", choices=PACKAGES, help="one package alone")
    options.add_argument("--coverage", type=Path, default=ROOT / ".coverage", help="data of coverage.py, by test")
    options.add_argument("--times", type=Path, default=ROOT / "out/tests.xml", help="times of the tests (JUnit XML)")
    asked = options.parse_args()
    for library in ("numba", "pandas", "pytest", "scipy.stats", "xarray"):
        import_module(library)  # once, for all children

    coverage = Coverage(asked.coverage, asked.times)
    chosen, survivors = drawn(asked.count, asked.seed, asked.of), []
    with tempfile.TemporaryDirectory(prefix="narrows-mutations-") as folder:
        shutil.copytree(ROOT / "src/narrows", Path(folder) / "narrows", ignore=shutil.ignore_patterns("__pycache__"))
        for number, mutation in enumerate(chosen, 1):
            noticed = is_noticed(mutation, coverage.tests_of(mutation), Path(folder))
            print(f"{number:4d} {'noticed ' if noticed else 'SURVIVES'} {mutation}", flush=True)
            survivors += [] if noticed else [mutation]
    print(f"\n{len(survivors)} of {len(chosen)} mutations survive")


if __name__ == "__main__":
    main()
