"""What writes a model into a file of another language."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from narrows.codegen.free_motion import Surge
from narrows.files import form_of, write_whole
from narrows.model.model import Model
from narrows.simulation.inputs import Contact
from narrows.simulation.ship import Points, SimulatedShip

if TYPE_CHECKING:
    from narrows.export.exported_ship import ExportedShip
    from narrows.waterway.waterway import Waterway


def write_c(
    model: Model, path: str | Path, *, waterway: "Waterway | None" = None, surge: Surge = "held",
    surge_inertia: float | None = None, coriolis: bool = False, contact: Contact | Points = "corners",
) -> None:  # fmt: skip
    """Write a model as one C99 header without dependencies: rates, step, room, voyages to contact, exact derivatives.

    Printed from the lines that voyages in Python are sailed by; what is in it begins with the name of the file.

    Parameters
    ----------
    model : Model
        The ship in its canal.
    path : str or Path
        Where to, as in ``ship.h``.
    waterway : Waterway, optional
        Where it sails instead of the model's own canal; its table goes into the file, and a caller may give another.
    surge : str
        ``held``: the speed stays; ``free``: it is integrated.
    surge_inertia : float [kg], optional
        Mass in surge with its added mass, for ``free`` where a_udot was not identifiable.
    coriolis : bool
        Add the rigid body's Coriolis force; the fitted damping at one speed holds it already.
    contact : str or points [m]
        ``corners`` of the hull's rectangle, ``midship`` as in the paper, or an outline of (forward, starboard);
        ``none`` in open water.

    Raises
    ------
    InputError
        Where the model lacks what its equations need, the ship does not fit the waterway, or the file cannot be
        written.
    """
    from narrows.export.c_header import c_text

    form_of(path, (".h",))
    write_whole(path, c_text(_exported(model, path, waterway, surge, surge_inertia, coriolis, contact)))


def write_javascript(
    model: Model, path: str | Path, *, waterway: "Waterway | None" = None, surge: Surge = "held",
    surge_inertia: float | None = None, coriolis: bool = False, contact: Contact | Points = "corners",
) -> None:  # fmt: skip
    """Write a model as one ES module without dependencies, its types as JSDoc: what ``write_c`` writes.

    Parameters
    ----------
    model : Model
        The ship in its canal.
    path : str or Path
        Where to, as in ``ship.mjs``.
    waterway : Waterway, optional
        Where it sails instead of the model's own canal; its table goes into the file, and a caller may give another.
    surge : str
        ``held``: the speed stays; ``free``: it is integrated.
    surge_inertia : float [kg], optional
        Mass in surge with its added mass, for ``free`` where a_udot was not identifiable.
    coriolis : bool
        Add the rigid body's Coriolis force; the fitted damping at one speed holds it already.
    contact : str or points [m]
        ``corners`` of the hull's rectangle, ``midship`` as in the paper, or an outline of (forward, starboard);
        ``none`` in open water.

    Raises
    ------
    InputError
        As ``write_c``.
    """
    from narrows.export.javascript_module import javascript_text

    form_of(path, (".mjs", ".js"))
    write_whole(path, javascript_text(_exported(model, path, waterway, surge, surge_inertia, coriolis, contact)))


def write_python(
    model: Model, path: str | Path, *, waterway: "Waterway | None" = None, surge: Surge = "held",
    surge_inertia: float | None = None, coriolis: bool = False, contact: Contact | Points = "corners",
) -> None:  # fmt: skip
    """Write a model as one Python file that needs NumPy alone: what ``write_c`` writes, for columns of ships too.

    Parameters
    ----------
    model : Model
        The ship in its canal.
    path : str or Path
        Where to, as in ``ship.py``.
    waterway : Waterway, optional
        Where it sails instead of the model's own canal; its table goes into the file, and a caller may give another.
    surge : str
        ``held``: the speed stays; ``free``: it is integrated.
    surge_inertia : float [kg], optional
        Mass in surge with its added mass, for ``free`` where a_udot was not identifiable.
    coriolis : bool
        Add the rigid body's Coriolis force; the fitted damping at one speed holds it already.
    contact : str or points [m]
        ``corners`` of the hull's rectangle, ``midship`` as in the paper, or an outline of (forward, starboard);
        ``none`` in open water.

    Raises
    ------
    InputError
        As ``write_c``.
    """
    from narrows.export.python_module import python_text

    form_of(path, (".py",))
    write_whole(path, python_text(_exported(model, path, waterway, surge, surge_inertia, coriolis, contact)))


def write_latex(model: Model, path: str | Path) -> None:
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
    from narrows.export.latex_equations import latex_text

    form_of(path, (".tex",))
    write_whole(path, latex_text(model))


def _exported(model: Model, path: str | Path, waterway: "Waterway | None", *choices: Any) -> "ExportedShip":
    from narrows.export.exported_ship import ExportedShip, prefix_of

    return ExportedShip(SimulatedShip(model, *choices), waterway, prefix_of(path))
