"""Lines as C99: numbers of structures unpacked before their first use, then an assignment a line."""

from collections.abc import Iterable, Mapping, Sequence
from textwrap import wrap

from narrows.codegen.free_motion import Expr
from narrows.codegen.lines import Program
from narrows.codegen.printers.python import Arithmetic, statements

WIDTH, TIED = 108, "\0=\0"
# Functions of <math.h> by what lines and plain functions call them.
LIBRARY = {"abs": "fabs", "exp": "exp", "log": "log", "sqrt": "sqrt", "power": "pow", "sine": "sin", "cosine": "cos",
           "floor": "floor", "hypot": "hypot", "cos": "cos", "sin": "sin"}  # fmt: skip
# Words that no number can be called by.
TAKEN = frozenset({
    "auto", "bool", "break", "case", "char", "const", "continue", "default", "do", "double", "else", "enum", "extern",
    "false", "float", "for", "goto", "if", "inline", "int", "long", "register", "restrict", "return", "short", "signed",
    "sizeof", "static", "struct", "switch", "true", "typedef", "union", "unsigned", "void", "volatile", "while",
    "INFINITY", "NAN", "near", "far", "small", "main", "state", "inputs", "constants", "parameters", "waterway",
    "result", "after", "lane", "rows", *LIBRARY.values(),
})  # fmt: skip


def c_name(name: str) -> str:
    """Return what a number is called in C."""
    return f"{name}_" if name in TAKEN else name


class CArithmetic(Arithmetic):
    """Expressions in C."""

    TABLE = "waterway"

    def __init__(self, prefix: str) -> None:
        super().__init__()
        self.prefix = prefix

    def called(self, name: str, *arguments: str) -> str:
        """Write the call of a function of <math.h>, or of the file."""
        return super().called(LIBRARY.get(name, f"{self.prefix}_{name}"), *arguments)

    def _print_Symbol(self, value: Expr) -> str:
        return c_name(value.name)


def c_body(program: Program, targets: Sequence[str], places: Mapping[str, str], printer: CArithmetic) -> list[str]:
    """Write a program as statements of C."""
    lines = unpacked([name for name in program.asked if name != places[name]], places)
    return lines + statements(program, targets, printer, "const double {} = {};", "{} = {};")


def unpacked(names: Iterable[str], places: Mapping[str, str]) -> list[str]:
    """Write the declaration of numbers by where they are found."""
    values = ", ".join(f"{c_name(name)} = {places[name]}" for name in names if name != places[name])
    whole = f"const double {values};".replace(" = ", TIED)  # No line breaks within a declaration.
    return [line.replace(TIED, " = ") for line in wrap(whole, WIDTH, subsequent_indent="    ")] if values else []
