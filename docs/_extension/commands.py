"""The command line as its code has it: what each verb prints for --help, at the width of a page."""

import os
import subprocess
import sys

from narrows.cli import app

WIDTH = 100
RUN = "from narrows.cli import main; main()"


def text() -> str:
    """Write the verbs, each below a heading of its own."""
    verbs = list(app.commands)
    parts = [_help(), *(f"## {verb}\n\n{_help(verb)}" for verb in sorted(verbs))]
    return "\n\n".join(parts)


def _help(*words: str) -> str:
    """In a process of its own: autodoc has changed the defaults of the functions in this one."""
    done = subprocess.run(
        [sys.executable, "-c", RUN, *words, "--help"], env={**os.environ, "COLUMNS": str(WIDTH)},
        stdout=subprocess.PIPE, text=True, encoding="utf-8", check=True,
    )  # fmt: skip
    return f"```text\n{done.stdout.rstrip().replace('Usage: -c', 'Usage: narrows')}\n```"
