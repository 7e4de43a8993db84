"""A model as a function of MATLAB and Octave."""

from pathlib import Path
from typing import TYPE_CHECKING

from narrows.export.exporter import Exporter, ship_to_export
from narrows.files import form_of, write_whole

if TYPE_CHECKING:
    from narrows.codegen.free_motion import Surge
    from narrows.model.model import Model


def write_matlab(
    model: "Model", path: str | Path, *, surge: "Surge" = "held", surge_inertia: float | None = None,
    coriolis: bool = False,
) -> None:  # fmt: skip
    """Write a model as ``xdot = ship(x, ui)`` for MATLAB and Octave, in the form of the Marine Systems Simulator.

    A path that ends in ``.c`` makes an S-function for Simulink with the same states and inputs, around the C of
    ``write_c``.

    The parameters and refusals are those of ``write_c``; the ship is in the model's own canal.

    References
    ----------
    Fossen and Perez, Marine Systems Simulator, https://github.com/cybergalactic/MSS
    """
    from narrows.export.ship_files import matlab_text, simulink_text

    form_of(path, EXPORTER.suffixes)
    ship = ship_to_export(model, path, None, surge, surge_inertia, coriolis, "corners")
    write_whole(path, simulink_text(ship) if Path(path).suffix == ".c" else matlab_text(ship))


EXPORTER = Exporter(
    "matlab", "a function of MATLAB and Octave in the form of MSS, or an S-function", (".m", ".c"), write_matlab,
    refused={"waterway": "a function of MATLAB has the canal of its model; leave --waterway out"},
)  # fmt: skip
