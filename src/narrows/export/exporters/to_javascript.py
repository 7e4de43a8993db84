"""A model as an ES module."""

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


def write_javascript(
    model: "Model", path: str | Path, *, waterway: "Waterway | None" = None, surge: "Surge" = "held",
    surge_inertia: float | None = None, coriolis: bool = False, contact: "Contact | Points" = "corners",
    controller: "ControlLaw | None" = None,
) -> None:  # fmt: skip
    """Write a model as one ES module without dependencies, with types as JSDoc and the content of ``write_c``.

    A path that ends in ``.tgz`` makes an npm package with types for TypeScript. The parameters and refusals are those
    of ``write_c``.
    """
    from narrows.export.ship_files import javascript_text, npm_bytes

    form_of(path, EXPORTER.suffixes)
    ship = ship_to_export(model, path, waterway, surge, surge_inertia, coriolis, contact, controller=controller)
    write_whole(path, npm_bytes(ship) if Path(path).suffix == ".tgz" else javascript_text(ship))


EXPORTER = Exporter("js", "an ES module, or an npm package of it with types", (".mjs", ".js", ".tgz"), write_javascript)
