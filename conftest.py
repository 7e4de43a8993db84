"""README, docs and examples are tests: every Python block runs, every console block must print what it shows."""

import os
import shlex
import subprocess
import sys
from pathlib import Path

from sybil import Sybil
from sybil.example import Example
from sybil.parsers.markdown import CodeBlockParser, PythonCodeBlockParser

ROOT = Path(__file__).parent


def run_console(example: Example) -> None:
    """Run each ``$ narrows`` line; where lines of output follow, they must be what it prints."""
    blocks = ("\n" + example.parsed).split("\n$ ")[1:]
    for block in blocks:
        command, _, expected = block.partition("\n")
        words = shlex.split(command, comments=True)
        if words[:1] != ["narrows"]:
            continue
        path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
        done = subprocess.run(
            words, cwd=ROOT, env={**os.environ, "PATH": path}, capture_output=True, text=True, timeout=300
        )
        shown = done.stdout + done.stderr
        assert done.returncode in (0, 2), shown
        for line in filter(None, map(str.strip, expected.splitlines())):
            assert line == "..." or line in shown, f"{command}: does not print {line!r} but\n{shown}"


pytest_collect_file = Sybil(
    parsers=[PythonCodeBlockParser(), CodeBlockParser(language="console", evaluator=run_console)],
    patterns=["*.md"],
    excludes=["CHANGELOG.md"],
).pytest()
