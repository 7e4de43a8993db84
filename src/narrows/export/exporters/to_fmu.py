"""A model as an FMU."""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from narrows.errors import InputError
from narrows.export.exporter import Exporter, check_standard, ship_to_export
from narrows.files import form_of, write_whole

if TYPE_CHECKING:
    from narrows.codegen.free_motion import Surge
    from narrows.model.model import Model
    from narrows.simulation.controllers import ControlLaw
    from narrows.simulation.inputs import Contact
    from narrows.simulation.ship import Points
    from narrows.waterway.waterway import Waterway


def write_fmu(
    model: "Model", path: str | Path, *, fmi: int = 2, u: float | None = None, dt: float | None = None,
    waterway: "Waterway | None" = None, surge: "Surge" = "held", surge_inertia: float | None = None,
    coriolis: bool = False, contact: "Contact | Points" = "corners",
    controller: "ControlLaw | None" = None,
) -> tuple[str, ...]:  # fmt: skip
    """Write a model as an FMU of FMI 2.0 or 3.0, co-simulation and model exchange.

    It compiles the output of ``write_c``. With ziglang (the extra ``fmu``) it compiles for Linux on x86-64 and aarch64,
    Windows and macOS; else for this machine alone, by its own compiler. Without a compiler the FMU contains sources
    only, as the standard allows.

    Parameters
    ----------
    model, path, waterway, surge, surge_inertia, coriolis, contact, controller
        As for ``write_c``.
    fmi : int
        Version of the standard: 2 or 3.
    u : float [m/s], optional
        Surge velocity at the start, which an importer may change; the ship's default unless given.
    dt : float [s], optional
        Longest step of co-simulation; the ship's default unless given.

    Returns
    -------
    tuple of str
        The platforms that it has a library for.

    Raises
    ------
    InputError
        As ``write_c``; where a compiler fails.
    """
    from narrows.export.exported_ship import USUAL_PREFIX
    from narrows.export.fmu import fmu_bytes
    from narrows.export.native_build import builds_here
    from narrows.simulation.initial_state import voyage_defaults
    from narrows.simulation.inputs import finite_numbers

    form_of(path, EXPORTER.suffixes)
    check_standard(fmi)
    defaults = voyage_defaults(model, u)
    speed, step = defaults.speed if u is None else u, defaults.dt if dt is None else dt
    finite_numbers(u=speed, dt=step)
    if not step > 0:
        raise InputError(f"dt = {step:g} s is no step; give a time over 0")
    ship = ship_to_export(model, path, waterway, surge, surge_inertia, coriolis, contact, controller=controller)
    builds = builds_here(fmi)
    inside = replace(ship, prefix=USUAL_PREFIX)
    write_whole(path, fmu_bytes(inside, ship.prefix, float(speed), float(step), builds, fmi))
    return tuple(dict.fromkeys(build.folder for build in builds))


def about_libraries(platforms: tuple[str, ...]) -> Iterable[str]:
    """Return the platforms of an FMU's libraries, and how to add more."""
    from narrows.export.native_build import lacks_zig

    alone = "no compiler is here: the FMU has its sources alone, which importers may compile"
    lacking = lacks_zig("an FMU for Linux, Windows and macOS at once")
    return [f"libraries for {', '.join(platforms)}" if platforms else alone, *filter(None, [lacking])]


EXPORTER = Exporter("fmu", "an FMU of FMI 2.0 or 3.0", (".fmu",), write_fmu, about_libraries, platforms=True)
