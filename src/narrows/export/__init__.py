"""Export: a model in other languages, printed from the lines that simulation uses.

Every format is a row of ``EXPORTERS``; ``nw.export(model, path)`` is ``nw.export.write``.
"""

import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from narrows.base.aliases import accept_aliases, part_named
from narrows.base.errors import InputError, check_choice
from narrows.base.files import form_of, write_whole
from narrows.base.named_values import by_name

if TYPE_CHECKING:
    from narrows.model.model import Model

__all__ = ["EXPORTERS", "LANGUAGES", "to_language", "write"]

PHYSICS = ("surge", "surge_inertia", "coriolis")
SHIP = (*PHYSICS, "contact", "waterway", "controller")
SHIP_FILE = ("ship_files", "ship_file")


@dataclass(frozen=True)
class Exporter:
    kind: str  # Name in ``narrows export``
    words: str  # Description
    suffixes: tuple[str, ...]  # Suffixes of its files
    # Module of this package, and its function of the model, the path, the suffix and ``options``. It returns the
    # content of the file, and what ``write`` returns.
    made_by: tuple[str, str]
    options: tuple[str, ...]
    # Notes on the written file, from the result of ``write``
    notes: Callable[[Any], Iterable[str]] = lambda written: ()

    def made(self, model: "Model", path: str | Path, options: Mapping[str, Any]) -> tuple[str | bytes, Any]:
        for name in options:
            check_choice("option", name, self.options)
        module, function = self.made_by
        content = getattr(import_module(f"narrows.export.{module}"), function)
        return content(model, path, form_of(path, self.suffixes), **options)  # type: ignore[no-any-return]


@accept_aliases
def write(model: "Model", path: str | Path, kind: str = "", **options: Any) -> Any:
    """Write a model in the language of the suffix.

    The files have rates, steps, clearance, voyages to contact and exact derivatives, printed from the lines that
    simulation in Python uses. Their names begin with the name of the file.

    The kinds and their suffixes are c (``.h``, ``.hpp``), js (``.mjs``, ``.js``), python (``.py``), matlab (``.m``),
    fmu (``.fmu``), page (``.html``), latex (``.tex``) and bank-force (``.h``, ``.cs``, ``.mjs``, ``.m``, ``.fmu``);
    ``EXPORTERS`` describes each. FMUs and pages need ziglang (the extra ``fmu``).

    Raises an InputError if there is no such language, an option does not apply, the model lacks coefficients for its
    equations, the ship does not fit the waterway, the controller is no law in arithmetic, a compiler fails, or the file
    cannot be written.

    Parameters
    ----------
    model : Model
        The ship in its canal.
    path : str or Path
        Path with a suffix of an export; or a kind, such as ``c``, whose text is returned.
    kind : str
        Its kind; only ``bank-force`` cannot be found from the suffix.
    **options : Any
        ``surge``, ``surge_inertia``, ``coriolis``, ``contact``: as for ``simulate``. ``waterway``: instead of the
        model's own canal; its table goes into the file, and a caller may give another. ``controller``: control law in
        the file instead of a caller's orders, such as ``nw.control.regulator(model, 0.0, u)``; its parameters are
        inputs with the prefix ``law_``, its memory joins the state. ``fmi``: standard of an FMU, 2 or 3. ``u``:
        surge velocity at the start of an FMU or page [m/s]. ``dt``: longest step of an FMU [s]. ``title``: of a page.
        ``kind`` decides which of them apply.

    Returns
    -------
    tuple of str or None
        Platforms that an FMU has a library for; notes on a page.
    """
    if str(path) in EXPORTERS and "." in kind:  # As in export(model, "c", "dtc.h")
        path, kind = kind, str(path)
    if str(path) in LANGUAGES and not kind:
        return to_language(model, str(path), **options)
    if kind and kind not in EXPORTERS:
        raise InputError(f"there is no export {kind!r}; give the model, the path and one of: {', '.join(EXPORTERS)}")
    exporter = EXPORTERS[kind] if kind else BY_SUFFIX[form_of(path, tuple(BY_SUFFIX))]
    content, result = exporter.made(model, path, options)
    write_whole(path, content)
    return result


def to_language(model: "Model", kind: str, path: str | Path | None = None, **options: Any) -> Any:
    """Write a model in one of ``LANGUAGES``, or return its text, or bytes, where no path is given."""
    exporter = LANGUAGES[kind]
    if path is not None:
        return write(model, path, exporter.kind, **options)
    return exporter.made(model, f"ship{exporter.suffixes[0]}", options)[0]


def about_libraries(platforms: tuple[str, ...]) -> Iterable[str]:
    """Return the platforms of an FMU's libraries, and how to add more."""
    from narrows.export.fmu import lacks_zig

    alone = "no compiler is here: the FMU has its sources alone, which importers may compile"
    lacking = lacks_zig("an FMU for Linux, Windows and macOS at once")
    return [f"libraries for {', '.join(platforms)}" if platforms else alone, *filter(None, [lacking])]


_ROWS = (
    Exporter(
        "bank-force", "the bank's force as one function in C and C++, C#, JavaScript, MATLAB and Octave, or as an FMU",
        (".m", ".h", ".cs", ".mjs", ".fmu"), ("fmu", "force_file"), ("fmi",),
    ),
    Exporter("c", "a header of C99 and C++, or one with a class", (".h", ".hpp"), SHIP_FILE, SHIP),
    Exporter(
        "fmu", "an FMU of FMI 2.0 or 3.0", (".fmu",), ("fmu", "fmu_file"), (*SHIP, "fmi", "u", "dt"), about_libraries,
    ),
    Exporter("js", "an ES module", (".mjs", ".js"), SHIP_FILE, SHIP),
    Exporter("latex", "the equations of the forces", (".tex",), ("ship_files", "latex_file"), ()),
    Exporter(
        "matlab", "a function of MATLAB and Octave in the form of MSS", (".m",), SHIP_FILE, PHYSICS,
    ),
    Exporter(
        "page", "a page that sails fleets in a browser", (".html",), ("page.assembly", "page_file"),
        (*PHYSICS, "contact", "title", "u"), tuple,
    ),
    Exporter("python", "a Python file that needs NumPy alone", (".py",), SHIP_FILE, SHIP),
)  # fmt: skip
# Formats of ``narrows export``, by name; those of a whole ship by suffix, which the bank's force alone shares.
EXPORTERS = by_name("exporters", ((own.kind, own) for own in _ROWS))
BY_SUFFIX = by_name(
    "suffixes of exporters",
    ((suffix, own) for own in _ROWS if own.kind != "bank-force" for suffix in own.suffixes),
)
# Methods ``to_c`` ... of a model.
LANGUAGES = {kind.replace("-", "_"): own for kind, own in EXPORTERS.items() if kind != "latex"}


def __getattr__(name: str) -> Any:
    if name in LANGUAGES:  # ``nw.export.c(model)``, as ``model.to_c()``
        return lambda model, path=None, **options: to_language(model, name, path, **options)
    return part_named(name, "export", __all__)


def __dir__() -> list[str]:
    return __all__


class _Export(ModuleType):
    __call__ = staticmethod(write)


sys.modules[__name__].__class__ = _Export
