"""The command line as its code has it: what each verb prints for --help, at the width of a page."""

import os
import subprocess
import sys

from narrows.cli import app

WIDTH = 100
BETWEEN = "\f"
RUN = f"""
import sys
from narrows.cli import app
for words in ([], *([verb] for verb in sys.argv[1:])):
    app.main([*words, "--help"], "narrows", standalone_mode=False)
    print({BETWEEN!r})
"""


def text() -> str:
    """Write the verbs, each below a heading of its own."""
    verbs = sorted(app.commands)
    # In a process of its own: autodoc has changed the defaults of the functions in this one.
    done = subprocess.run(
        [sys.executable, "-c", RUN, *verbs], env={**os.environ, "COLUMNS": str(WIDTH)},
        stdout=subprocess.PIPE, text=True, encoding="utf-8", check=True,
    )  # fmt: skip
    first, *others = (f"```text\n{part.strip()}\n```" for part in done.stdout.split(BETWEEN)[:-1])
    return "\n\n".join([first, *(f"## {verb}\n\n{part}" for verb, part in zip(verbs, others, strict=True))])
