"""What is said while Numba compiles a generated module: that it does, and how far it has come."""

import logging
import re
from collections.abc import Callable
from contextlib import ExitStack
from types import ModuleType
from typing import Any

from numba.core import event

from narrows.progress import bar, is_shown

COMPILED = re.compile(r"^@(jit|called|cached|numba\.njit.*)\ndef (\w+)", re.MULTILINE)
# How many functions of each generated file are compiled, by its name.
FUNCTIONS: dict[str, int] = {}


class CompilationBar(event.Listener):  # type: ignore[misc]
    """Counts functions of generated modules as Numba compiles them; its lock lets in one thread at a time."""

    def __init__(self) -> None:
        self.depth = 0
        self.shown = ExitStack()
        self.advance: Callable[[int], None] = lambda done: None

    def on_start(self, event: Any) -> None:
        """Begin the bar with the outermost function."""
        if (total := FUNCTIONS.get(_file(event))) is None:
            return
        if self.depth == 0:
            logging.getLogger("narrows").info(
                "compiling these equations, which takes some seconds and is kept for the next time ..."
            )
            self.advance = self.shown.enter_context(bar(total, is_shown(), "compiling"))
        self.depth += 1

    def on_end(self, event: Any) -> None:
        """Count a function, and end the bar with the outermost."""
        if _file(event) in FUNCTIONS:
            self.advance(1)
            self.depth -= 1
            if self.depth == 0:
                self.shown.close()


def _file(event: Any) -> str:
    return str(event.data["dispatcher"].py_func.__code__.co_filename)


def watch(module: ModuleType, text: str) -> None:
    """Say from now on when functions of a generated module are compiled."""
    if not FUNCTIONS:
        event.register("numba:compile", CompilationBar())
    FUNCTIONS[str(module.__file__)] = count_of_compiled(text)


def count_of_compiled(text: str) -> int:
    """Return how many functions of a module are compiled: those that are called in it, or kept."""
    functions = COMPILED.findall(text)
    return sum(how == "cached" or len(re.findall(rf"\b{name}\(", text)) > 1 for how, name in functions)
