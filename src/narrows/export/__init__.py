"""Export: a model in other languages, printed from the lines that simulation uses."""

from inspect import signature
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from narrows.aliases import name_here, public_name
from narrows.errors import check_choice
from narrows.export.exporters import (
    EXPORTERS,
    write_bank_force,
    write_c,
    write_fmu,
    write_javascript,
    write_latex,
    write_matlab,
    write_page,
    write_python,
)
from narrows.files import form_of

if TYPE_CHECKING:
    from narrows.model.model import Model

# Exporters of a whole ship by suffix: the exporter of the bank's force alone shares suffixes with others.
BY_SUFFIX = {suffix: own for own in EXPORTERS.values() if own.kind != "bank-force" for suffix in own.suffixes}


LANGUAGES = {kind.replace("-", "_"): own for kind, own in EXPORTERS.items() if kind != "latex"}


def to_language(model: "Model", kind: str, path: str | Path | None = None, **options: Any) -> Any:
    """Write a model in one of ``LANGUAGES``, or return its text, or bytes, where no path is given."""
    if path is not None:
        return LANGUAGES[kind].write(model, path, **options)
    with TemporaryDirectory() as folder:
        file = Path(folder) / f"ship{LANGUAGES[kind].suffixes[0]}"
        LANGUAGES[kind].write(model, file, **options)
        return file.read_bytes() if file.suffix in (".fmu", ".tgz") else file.read_text(encoding="utf-8")


def write(model: "Model", path: str | Path, **options: Any) -> Any:
    """Write a model in the language of the suffix.

    Parameters
    ----------
    model : Model
        The ship in its canal.
    path : str or Path
        Path with suffix ``.h``, ``.hpp``, ``.fmu``, ``.mjs``, ``.html``, ``.m``, ``.c`` (Simulink),
        ``.py`` or ``.tex``.
    **options : Any
        Options of that language's exporter: ``write_c``, ``write_fmu`` ...

    Raises
    ------
    InputError
        If there is no such language, or the exporter refuses.
    """
    exporter = BY_SUFFIX[form_of(path, tuple(BY_SUFFIX))]
    known = [own for own in signature(exporter.write).parameters if own not in ("model", "path")]
    for name in options:
        check_choice("option", name, known)
    return exporter.write(model, path, **options)


__all__ = [
    "EXPORTERS", "write", "write_bank_force", "write_c", "write_fmu", "write_javascript", "write_latex", "write_matlab",
    "write_page", "write_python",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    if (same := name_here(name, "parts")) in __all__:
        return globals()[same]
    raise AttributeError(f"nw.export has no {name!r}{public_name(name, __all__)}")
