"""A model as a Python file."""

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


def write_python(
    model: "Model", path: str | Path, *, waterway: "Waterway | None" = None, surge: "Surge" = "held",
    surge_inertia: float | None = None, coriolis: bool = False, contact: "Contact | Points" = "corners",
    controller: "ControlLaw | None" = None,
) -> None:  # fmt: skip
    """Write a model as one Python file that needs NumPy alone: the content of ``write_c``, also for columns of ships.

    The parameters and refusals are those of ``write_c``.
    """
    from narrows.export.ship_files import python_text

    form_of(path, EXPORTER.suffixes)
    ship = ship_to_export(model, path, waterway, surge, surge_inertia, coriolis, contact, controller=controller)
    write_whole(path, python_text(ship))


EXPORTER = Exporter("python", "a Python file that needs NumPy alone", (".py",), write_python)
