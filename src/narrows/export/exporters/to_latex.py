"""The equations of a model."""

from pathlib import Path
from typing import TYPE_CHECKING

from narrows.export.exporter import Exporter
from narrows.files import form_of, write_whole

if TYPE_CHECKING:
    from narrows.model.model import Model


def write_latex(model: "Model", path: str | Path) -> None:
    """Write the equations of the forces with their symbols, and again with the numbers of a model.

    Parameters
    ----------
    model : Model
        The ship in its canal.
    path : str or Path
        Where to, as in ``ship.tex``.

    Raises
    ------
    InputError
        Where the file cannot be written.
    """
    from narrows.codegen.printers.latex import latex
    from narrows.export.passport import passport
    from narrows.export.rendering import commented

    form_of(path, EXPORTER.suffixes)
    lines = [f"% {commented(line)}" for line in passport(model)]
    for coefficients in (None, model.coefficients):
        lines += ["\\begin{equation}", latex(model.terms, coefficients), "\\end{equation}"]
    write_whole(path, "\n".join(lines) + "\n")


EXPORTER = Exporter("latex", "the equations of the forces", (".tex",), write_latex)
