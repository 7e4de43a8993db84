"""The equations of a model."""

from pathlib import Path
from typing import TYPE_CHECKING

from narrows.export.exporter import Exporter
from narrows.files import form_of, write_whole

if TYPE_CHECKING:
    from narrows.model.model import Model


def write_latex(model: "Model", path: str | Path) -> None:
    """Write the equations of the forces, once with symbols and once with the numbers of a model, and its particulars.

    It needs the LaTeX package amsmath.

    Parameters
    ----------
    model : Model
        The ship in its canal.
    path : str or Path
        Output file, as in ``ship.tex``.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    from narrows.codegen.printers.latex import Equations, environment
    from narrows.export.exported_ship import ExportedShip
    from narrows.export.passport import passport
    from narrows.export.rendering import commented
    from narrows.quantities.names import FORCES
    from narrows.simulation.ship import SimulatedShip

    form_of(path, EXPORTER.suffixes)
    about = [*passport(model), ExportedShip(SimulatedShip(model)).bottom_note]
    lines = [f"% {commented(line)}" for line in about]
    written = Equations(model.terms)
    by_symbols = [*written.of_forces(tuple(FORCES)), *written.definitions()]
    by_numbers = written.of_forces(tuple(FORCES), model.coefficients)
    numbers = written.values(model.configuration.values())
    # Pages break between lines.
    parts = [environment("align*", one) for one in (by_symbols, by_numbers, numbers) if one]
    write_whole(path, "\n".join([*lines, "{\\allowdisplaybreaks", *parts, "}"]) + "\n")


EXPORTER = Exporter("latex", "the equations of the forces", (".tex",), write_latex)
