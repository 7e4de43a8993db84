"""Lines as statements of a language: its names, numbers and functions."""

import re
from collections.abc import Iterable, Mapping, Sequence
from keyword import kwlist
from typing import ClassVar

from narrows.codegen.free_motion import Expr
from narrows.codegen.lines import Program
from narrows.codegen.printers.python import Arithmetic, statements


class Language(Arithmetic):
    TABLE = "waterway"
    TAKEN: frozenset[str] = frozenset()  # Reserved words
    LIBRARY: ClassVar[Mapping[str, str]] = {}  # Elementary functions by their names in lines and plain functions
    FIELD, DECLARED, ASSIGNED = "{}.{}", "{} = {};", "{} = {};"
    COMMENT = "  // {}"  # After a statement
    INFINITE, NO_NUMBER = "inf", "nan"

    def __init__(self, prefix: str = "") -> None:
        super().__init__()
        self.prefix = prefix

    def named(self, name: str) -> str:
        return f"{name}_" if name in self.TAKEN else name

    def literal(self, value: float) -> str:
        text = repr(float(value))
        return {"inf": self.INFINITE, "-inf": f"-{self.INFINITE}", "nan": self.NO_NUMBER}.get(text, text)

    def commented(self, line: str, meaning: str) -> str:
        return line + self.COMMENT.format(meaning) if meaning else line

    def field(self, structure: str, name: str) -> str:
        return self.FIELD.format(structure, self.named(name))

    def called(self, name: str, *arguments: str) -> str:
        return super().called(self.LIBRARY.get(name, name), *arguments)

    def _print_Symbol(self, value: Expr) -> str:
        return self.named(value.name)

    def unpacked(self, names: Iterable[str], places: Mapping[str, str]) -> list[str]:
        """Write the declaration of numbers by where they are found."""
        return [self.DECLARED.format(self.named(name), places[name]) for name in names if name != places[name]]

    def body(self, program: Program, targets: Sequence[str], places: Mapping[str, str]) -> list[str]:
        return self.unpacked(program.asked, places) + statements(program, targets, self, self.DECLARED, self.ASSIGNED)


class PythonFile(Language):
    TAKEN = frozenset({
        "state", "inputs", "constants", "parameters", "waterway", "result", "np", "abs", "sine", "cosine", *kwlist,
    })  # fmt: skip
    LIBRARY: ClassVar = {"cos": "np.cos", "sin": "np.sin"}
    DECLARED = ASSIGNED = "{} = {}"
    COMMENT = "  # {}"


class JavaScript(Language):
    TAKEN = frozenset({
        "await", "break", "case", "catch", "class", "const", "continue", "debugger", "default", "delete", "do", "else",
        "enum", "export", "extends", "false", "finally", "for", "function", "if", "import", "in", "instanceof", "let",
        "new", "null", "return", "static", "super", "switch", "this", "throw", "true", "try", "typeof", "var", "void",
        "while", "with", "yield", "arguments", "eval", "Math", "state", "inputs", "constants", "parameters", "waterway",
        "result",
    })  # fmt: skip
    LIBRARY: ClassVar = {
        **{own: f"Math.{own}" for own in ("abs", "exp", "log", "sqrt", "floor", "hypot", "cos", "sin", "min", "max")},
        "sine": "Math.sin", "cosine": "Math.cos", "power": "Math.pow", "whole": "Math.trunc", "int": "Math.trunc",
    }  # fmt: skip
    DECLARED = "const {} = {};"
    INFINITE, NO_NUMBER = "Infinity", "NaN"


class CSharp(Language):
    LIBRARY: ClassVar = {
        name: re.sub(r"\.(\w)", lambda at: f".{at[1].upper()}", own) for name, own in JavaScript.LIBRARY.items()
    }
    DECLARED = "double {} = {};"


class Matlab(Language):
    """MATLAB and Octave, with arrays element by element."""

    TAKEN = frozenset({
        "x", "ui", "xdot", "U", "beyond", "i", "j", "pi", "eps", "end", "for", "if", "while", "function", "otherwise",
    })  # fmt: skip
    LIBRARY: ClassVar = {"sine": "sin", "cosine": "cos", "minimum": "min", "maximum": "max", "whole": "fix"}
    COMMENT = "  % {}"

    def doprint(self, expression: Expr) -> str:
        return re.sub(r"([*/])", r".\1", super().doprint(expression))
