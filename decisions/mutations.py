"""Mutations: small errors put into the code one at a time, to see that a test fails for each.

Each mutation changes one operator, comparison or number of a file; the tests of its package then run until
the first failure. What no test notices is printed as a survivor, with its line before and after.

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

ROOT = Path(__file__).parents[1]
# Tests of a package or of a part of it, the quickest first: the run of a mutation ends at the first failure. The
# longest name that a file begins with counts.
TESTS = {
    "estimation": [
        "unit/test_estimation_numbers.py",
        "unit/test_estimation_algebra.py",
        "unit/test_estimator.py",
        "unit/test_consistency.py",
    ],
    "estimation/fault_bank.py": [
        "unit/test_fault_bank.py",
        "unit/test_estimation_numbers.py",
        "unit/test_estimation_algebra.py",
        "unit/test_estimator.py",
        "warning/test_monitor_sensors.py",
    ],
    "control": ["engine/test_regulator.py", "engine/test_linear_system.py", "engine/test_speed_governor.py"],
    "control/predictive": ["engine/test_predictive_parts.py", "engine/test_predictive.py"],
    "warning": ["warning/test_alerts.py", "warning/test_scores.py", "warning/test_monitor_sensors.py"],
    "warning/alerts": ["warning/test_alerts.py", "warning/test_monitor.py"],
    "warning/forecasting": ["warning/test_scores.py", "warning/test_forecast.py"],
    "warning/inputs": ["warning/test_nmea_decoder.py"],
    "warning/monitoring": ["warning/test_monitor_sensors.py", "warning/test_monitor.py", "warning/test_bridge_page.py"],
    "warning/page": ["warning/test_page_requests.py", "warning/test_bridge_page.py", "warning/test_clients.py"],
    "warning/monitoring/watched_transit.py": ["warning/test_scores.py", "warning/test_watched_transits.py"],
    "safety": ["unit/test_envelope_parts.py", "unit/test_envelope.py", "unit/test_pilots.py"],
    "safety/channel_rules.py": ["unit/test_channel_rules.py"],
    "logbook": ["unit/test_learned_coefficient.py", "unit/test_ship_log.py", "unit/test_sensor_grades.py"],
    "logbook/checking": ["unit/test_check_log.py"],
    "logbook/filtering": ["unit/test_record_filter.py", "unit/test_log_posterior.py", "unit/test_learn.py"],
    "logbook/learning": ["unit/test_log_posterior.py", "unit/test_learn.py", "unit/test_learn_transits.py"],
    "logbook/reading": ["unit/test_read_log.py", "unit/test_nmea.py"],
    "logbook/steady_legs": ["unit/test_learn_steady.py", "unit/test_plan_steady.py"],
    "logbook/transits": ["unit/test_predict_information.py", "unit/test_learn_transits.py"],
    "identification/least_squares.py": ["unit/test_solve.py", "unit/test_normal_equations.py"],
    "identification/mixed_model.py": ["unit/test_mixed_model.py", "unit/test_trust.py"],
}
PACKAGES = [name for name in TESTS if "/" not in name or name.startswith("identification")]
TIME_LIMIT = 300  # [s], after which a mutation counts as noticed: it made something endless
NOT_RUN = 70  # exit code of a child in which pytest itself fails
ROUNDING = 1e-6  # a smaller number guards against rounding: twice as much is as good
SWAPS: dict[type, type] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Lt: ast.GtE, ast.GtE: ast.Lt,
    ast.Gt: ast.LtE, ast.LtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip
# Functions that only word or draw a result, and arguments of caches and iterations: another number there is no error.
WORDING = re.compile(r"summary|notes|words|describe.*|_?(plot|draw|print).*|__(repr|str)__")
OF_NO_CLAIM = re.compile(r"maxsize|maxiter|ftol|xtol|rtol|atol|figsize|dpi|digits")
# Constants that bound memory, waiting and rounding: twice the number is as good.
BOUNDS = re.compile(
    r"MOST_\w+|LONGEST_\w+|SAME\w*|\w+_(QUEUE|TIMEOUT|INTERVAL|PAUSE|RETRY|TOLERANCE)|\w*BLOCK|STEPS\w*"
)


@dataclass(frozen=True)
class Mutation:
    """One changed place of one file."""

    path: Path  # of the file, relative to the package
    line: int
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


def places(node: ast.AST) -> Iterator[tuple[ast.AST, str, int]]:
    """Each node that can be changed, as its parent, the field and the index in it (-1: the field itself)."""
    for field, value in ast.iter_fields(node):
        if field in ("annotation", "returns", "decorator_list"):
            continue
        for index, child in enumerate(value if isinstance(value, list) else [value]):
            if not isinstance(child, ast.AST) or is_left_out(child):
                continue
            # A bare index is a name of a place and no arithmetic.
            named = isinstance(node, ast.Subscript) and isinstance(child, ast.Constant)
            if isinstance(child, ast.expr) and not named and changed(child) is not None:
                yield node, field, index if isinstance(value, list) else -1
            yield from places(child)


def mutations(path: Path) -> list[Mutation]:
    """All mutations of a file."""
    found = []
    for place, (parent, field, index) in enumerate(places(ast.parse((ROOT / "src/narrows" / path).read_text("utf-8")))):
        value = getattr(parent, field)
        node = value if index < 0 else value[index]
        found.append(Mutation(path, node.lineno, place, ast.unparse(node), ast.unparse(changed(node))))
    return found


def mutated(mutation: Mutation) -> str:
    """The text of the file with its error in it."""
    tree = ast.parse((ROOT / "src/narrows" / mutation.path).read_text("utf-8"))
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


def tests_of(path: Path) -> list[str]:
    """The tests of a file of the package."""
    return TESTS[max((name for name in TESTS if path.as_posix().startswith(name)), key=len)]


def is_noticed(mutation: Mutation, source: Path) -> bool:
    """Run the tests of a file on a copy of the package that has the error in it."""
    file = source / "narrows" / mutation.path
    whole = file.read_text("utf-8")
    file.write_text(mutated(mutation), "utf-8")
    try:
        return not succeed(tests_of(mutation.path), source)
    finally:
        file.write_text(whole, "utf-8")


def succeed(tests: list[str], source: Path) -> bool:
    """Whether tests pass, in a process of its own, which shares the libraries that are loaded already."""
    child = os.fork()
    if not child:
        try:
            os._exit(run_tests(tests, source))
        finally:
            os._exit(NOT_RUN)
    status = os.waitpid(child, 0)[1]
    # 0: all pass; 1: one fails; 2: none can be collected, as where an import fails. Others tell nothing of the code.
    if os.WIFEXITED(status) and os.WEXITSTATUS(status) > 2:
        raise SystemExit(f"pytest does not run {', '.join(tests)} (exit code {os.WEXITSTATUS(status)})")
    return status == 0


def run_tests(tests: list[str], source: Path) -> int:
    import pytest

    signal.alarm(TIME_LIMIT)
    os.environ["PYTHONPATH"] = str(source)
    sys.path.insert(0, str(source))
    sys.dont_write_bytecode = True
    os.chdir(ROOT)
    paths = [f"tests/{name}" for name in tests]
    with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
        return int(pytest.main(["-x", "-q", "-m", "not slow", "-p", "no:xdist", *paths]))


def main() -> None:
    """Make the mutations and print the survivors."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--count", type=int, default=100, help="how many mutations")
    options.add_argument("--seed", type=int, default=0, help="of the choice")
    options.add_argument("--of", choices=PACKAGES, help="one package alone")
    options.add_argument("--unchecked", action="store_true", help="do not first see that the tests pass without error")
    asked = options.parse_args()
    for library in ("numba", "pandas", "pytest", "scipy.stats", "xarray"):
        import_module(library)  # once, for all children

    chosen, survivors = drawn(asked.count, asked.seed, asked.of), []
    with tempfile.TemporaryDirectory(prefix="narrows-mutations-") as folder:
        shutil.copytree(ROOT / "src/narrows", Path(folder) / "narrows", ignore=shutil.ignore_patterns("__pycache__"))
        # What fails without an error notices everything.
        for tests in [] if asked.unchecked else {tuple(tests_of(one.path)) for one in chosen}:
            if not succeed([*tests], Path(folder)):
                raise SystemExit(f"tests fail without a mutation: {', '.join(tests)}")
        for number, mutation in enumerate(chosen, 1):
            noticed = is_noticed(mutation, Path(folder))
            print(f"{number:4d} {'noticed ' if noticed else 'SURVIVES'} {mutation}", flush=True)
            survivors += [] if noticed else [mutation]
    print(f"\n{len(survivors)} of {len(chosen)} mutations survive")


if __name__ == "__main__":
    main()
