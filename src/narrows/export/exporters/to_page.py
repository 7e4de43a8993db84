"""A model as an HTML page."""

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

# Contact setting of open water.
OPEN = "none"


def write_page(
    model: "Model", path: str | Path, *, title: str = "", u: float | None = None, surge: "Surge" = "held",
    surge_inertia: float | None = None, coriolis: bool = False, contact: "Contact | Points" = "corners",
) -> tuple[str, ...]:  # fmt: skip
    """Write a model as one HTML page that simulates fleets in a browser, without a network or a library.

    It shows a fan of thousands of ships in the canal, where they ground, a map of starts and speeds, which way the
    banks turn the bow, sliders for the inputs of the terms, and a helm if there is a rudder. With ziglang (the extra
    ``fmu``) it runs WebAssembly, one worker a core; without it the JavaScript of ``write_javascript``.

    Parameters
    ----------
    model, path, surge, surge_inertia, coriolis, contact
        As for ``write_c``, but the page needs banks.
    title : str
        Title of the page; the ship's name unless given.
    u : float [m/s], optional
        Initial speed, which the user of the page may change; the ship's default unless given.

    Returns
    -------
    tuple of str
        Notes: why it runs without WebAssembly, or why there is no helm.

    Raises
    ------
    InputError
        As ``write_c``; if the contact is ``none``, or the compiler fails.
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
