"""A model as a header of C99 and C++."""

from pathlib import Path
from typing import TYPE_CHECKING

from narrows.export.exporter import Exporter, ship_to_export
from narrows.files import form_of, write_whole

if TYPE_CHECKING:
    from narrows.codegen.free_motion import Surge
    from narrows.model.model import Model
    from narrows.simulation.controllers import ControlLaw
    from narrows.simulation.inputs import Contact
    from narrows.simulation.ship import Points
    from narrows.waterway.waterway import Waterway


def write_c(
    model: "Model", path: str | Path, *, waterway: "Waterway | None" = None, surge: "Surge" = "held",
    surge_inertia: float | None = None, coriolis: bool = False, contact: "Contact | Points" = "corners",
    controller: "ControlLaw | None" = None,
) -> None:  # fmt: skip
    """Write a model as one header of C99 and C++ without dependencies.

    It has rates, steps, clearance, voyages to contact and exact derivatives, printed from the lines that simulation in
    Python uses. Its names begin with the name of the file.

    Parameters
    ----------
    model : Model
        The ship in its canal.
    path : str or Path
        Path with suffix ``.h``, or ``.hpp`` for the same in a C++ class.
    waterway : Waterway, optional
        Waterway instead of the model's own canal; its table goes into the file, and a caller may give another.
    surge : str
        ``held``: constant speed; ``free``: speed is integrated.
    surge_inertia : float [kg], optional
        Mass in surge with its added mass, for ``free`` if a_udot was not identifiable.
    coriolis : bool
        Add the rigid body's Coriolis force; damping fitted at one speed already contains it.
    contact : str or points [m]
        ``corners`` of the hull's rectangle, ``midship`` as in the paper, or an outline of (forward, starboard);
        ``none`` in open water.
    controller : ControlLaw, optional
        Control law in the file instead of a caller's orders, such as ``nw.control.regulator(model, 0.0, u)``. Its
        parameters are inputs with the prefix ``law_``; its memory joins the state.

    Raises
    ------
    InputError
        If the model lacks coefficients for its equations, the ship does not fit the waterway, the controller is no law
        in arithmetic, or the file cannot be written.
    """
    from narrows.export.ship_files import c_text, cpp_text

    form_of(path, EXPORTER.suffixes)
    ship = ship_to_export(model, path, waterway, surge, surge_inertia, coriolis, contact, controller=controller)
    write_whole(path, cpp_text(ship) if Path(path).suffix == ".hpp" else c_text(ship))


EXPORTER = Exporter("c", "a header of C99 and C++, or one with a class", (".h", ".hpp"), write_c)
