"""A model as a page in a browser."""

from pathlib import Path
from typing import TYPE_CHECKING

from narrows.errors import InputError
from narrows.export.exporter import Exporter
from narrows.files import form_of, write_whole

if TYPE_CHECKING:
    from narrows.codegen.free_motion import Surge
    from narrows.model.model import Model
    from narrows.simulation.inputs import Contact
    from narrows.simulation.ship import Points

# The contact of open water.
OPEN = "none"


def write_page(
    model: "Model", path: str | Path, *, title: str = "", u: float | None = None, surge: "Surge" = "held",
    surge_inertia: float | None = None, coriolis: bool = False, contact: "Contact | Points" = "corners",
) -> tuple[str, ...]:  # fmt: skip
    """Write a model as one HTML page that sails fleets of it in a browser, without a network or a library.

    It shows a fan of thousands of ships in the canal, where they ground, a map of starts and speeds, which way the
    banks turn the bow, sliders for what the terms ask for, and a helm where there is a rudder. With ziglang (the extra
    ``fmu``) it sails by WebAssembly, one worker a core; without it by the JavaScript of ``write_javascript``.

    Parameters
    ----------
    model, path, surge, surge_inertia, coriolis, contact
        As for ``write_c``, but that a page has banks.
    title : str
        Title of the page; the ship's name unless given.
    u : float [m/s], optional
        Speed that it begins with, which whoever plays may change; what suits the ship unless given.

    Returns
    -------
    tuple of str
        What to say of it: how it sails where that is not by WebAssembly, and why there is no helm.

    Raises
    ------
    InputError
        As ``write_c``; where the contact is ``none``, or the compiler fails.
    """
    from narrows.export.page.assembly import assembled
    from narrows.simulation.ship import SimulatedShip

    form_of(path, EXPORTER.suffixes)
    if contact == OPEN:
        raise InputError("a page shows a canal, and contact 'none' has no banks; choose 'corners'")
    text, notes = assembled(SimulatedShip(model, surge, surge_inertia, coriolis, contact), title, u)
    write_whole(path, text)
    return notes


EXPORTER = Exporter(
    "page", "a page that sails fleets in a browser", (".html",), write_page, tuple,
    refused={"waterway": "a page shows a straight canal; leave --waterway out"},
)  # fmt: skip
