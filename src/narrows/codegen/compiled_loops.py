"""Loops that are written in Python and compiled: a module of them as it stands, each function by Numba."""

import inspect
import re
from functools import lru_cache
from importlib.util import find_spec
from types import ModuleType

from narrows.codegen.cache import generated

HEADER = '''"""Made by narrows from {name}: made again where it is missing, so do not edit."""
import numba

cached = numba.njit(fastmath={{"nsz", "contract"}}, error_model="numpy", nogil=True, cache=True)

'''


@lru_cache
def compiled_loops(module: ModuleType) -> ModuleType:
    """Return a module's functions, compiled when they are called; as they stand where there is no Numba."""
    if find_spec("numba") is None:
        return module
    text = inspect.getsource(module)
    name = module.__name__.rpartition(".")[2]
    return generated(name, [text, HEADER], lambda: HEADER.format(name=name) + _decorated(text))


def _decorated(text: str) -> str:
    """Without what the module says of itself, which comes before the imports of the header."""
    return re.sub(r"^def ", "@cached\ndef ", text.split('"""\n', 1)[1], flags=re.MULTILINE)
