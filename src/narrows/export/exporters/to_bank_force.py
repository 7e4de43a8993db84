"""The bank's force of a model as one function."""

from pathlib import Path
from typing import TYPE_CHECKING

from narrows.export.exporter import Exporter, check_standard
from narrows.files import form_of, write_whole

if TYPE_CHECKING:
    from narrows.model.model import Model


def write_bank_force(model: "Model", path: str | Path, *, fmi: int = 2) -> None:
    """Write the bank's force as one function, for a simulator with its own hull model.

    It takes offset, heading, speed and the section of the water (two banks, their slopes, the depth). It returns sway
    force and yaw moment, their standard deviations, and whether the model's tests covered the input.

    Parameters
    ----------
    model : Model
        A model with a bank term.
    path : str or Path
        Path with suffix ``.h`` for C and C++, ``.cs`` for C#, ``.mjs`` for JavaScript, ``.m`` for MATLAB and Octave,
        ``.fmu`` for an FMU without states.
    fmi : int
        Version of the FMI standard: 2 or 3.

    Raises
    ------
    InputError
        If the model has no bank force, or the file cannot be written.
    """
    from narrows.export.exported_ship import prefix_of
    from narrows.export.force_files import force_fmu, force_text

    form_of(path, EXPORTER.suffixes)
    check_standard(fmi)
    fmu = Path(path).suffix == ".fmu"
    write_whole(path, force_fmu(model, prefix_of(path), fmi) if fmu else force_text(model, path, prefix_of(path)))


EXPORTER = Exporter(
    "bank-force", "the bank's force as one function in C and C++, C#, JavaScript, MATLAB and Octave, or as an FMU",
    (".m", ".h", ".cs", ".mjs", ".fmu"), write_bank_force,
    refused={"waterway": "the bank's force takes the section as input; leave --waterway out"},
)  # fmt: skip
