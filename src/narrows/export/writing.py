"""What writes a model into a file of another language."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from narrows.errors import InputError
from narrows.files import form_of, write_whole

if TYPE_CHECKING:
    from narrows.codegen.free_motion import Surge
    from narrows.export.exported_ship import ExportedShip
    from narrows.model.model import Model
    from narrows.simulation.inputs import Contact
    from narrows.simulation.ship import Points
    from narrows.waterway.waterway import Waterway

# ``narrows.export`` gives each of these.
__all__ = ["write_bank_force", "write_c", "write_fmu", "write_javascript", "write_latex", "write_page", "write_python"]

# The contact of open water.
OPEN = "none"


def write_c(
    model: "Model", path: str | Path, *, waterway: "Waterway | None" = None, surge: "Surge" = "held",
    surge_inertia: float | None = None, coriolis: bool = False, contact: "Contact | Points" = "corners",
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
    from narrows.export.rendering import c_text

    form_of(path, (".h",))
    write_whole(path, c_text(_exported(model, path, waterway, surge, surge_inertia, coriolis, contact)))


def write_javascript(
    model: "Model", path: str | Path, *, waterway: "Waterway | None" = None, surge: "Surge" = "held",
    surge_inertia: float | None = None, coriolis: bool = False, contact: "Contact | Points" = "corners",
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
    from narrows.export.scripts import javascript_text

    form_of(path, (".mjs", ".js"))
    write_whole(path, javascript_text(_exported(model, path, waterway, surge, surge_inertia, coriolis, contact)))


def write_python(
    model: "Model", path: str | Path, *, waterway: "Waterway | None" = None, surge: "Surge" = "held",
    surge_inertia: float | None = None, coriolis: bool = False, contact: "Contact | Points" = "corners",
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
    from narrows.export.scripts import python_text

    form_of(path, (".py",))
    write_whole(path, python_text(_exported(model, path, waterway, surge, surge_inertia, coriolis, contact)))


def write_latex(model: "Model", path: str | Path) -> None:
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
    from narrows.export.scripts import latex_text

    form_of(path, (".tex",))
    write_whole(path, latex_text(model))


def write_bank_force(model: "Model", path: str | Path) -> None:
    """Write the bank's force as one function, for a simulator that has a hull of its own.

    It takes offset, heading, speed and the section of the water (two banks, their slopes, the depth), and gives sway
    force and yaw moment, their standard deviations, and whether the tests of the model covered the question.

    Parameters
    ----------
    model : Model
        A model with a bank term.
    path : str or Path
        Where to: ``.h`` for C and C++, ``.cs`` for C#, ``.mjs`` for JavaScript, ``.m`` for MATLAB and Octave.

    Raises
    ------
    InputError
        Where the model has no bank force, or the file cannot be written.
    """
    from narrows.export.bank_force import LANGUAGES, force_text
    from narrows.export.exported_ship import prefix_of

    form_of(path, tuple(LANGUAGES))
    write_whole(path, force_text(model, path, prefix_of(path)))


def write_fmu(
    model: "Model", path: str | Path, *, fmi: int = 2, u: float | None = None, dt: float | None = None,
    waterway: "Waterway | None" = None, surge: "Surge" = "held", surge_inertia: float | None = None,
    coriolis: bool = False, contact: "Contact | Points" = "corners",
) -> tuple[str, ...]:  # fmt: skip
    """Write a model as an FMU of FMI 2.0 or 3.0, co-simulation and model exchange.

    What ``write_c`` writes, compiled. With ziglang (the extra ``fmu``) for Linux on x86-64 and aarch64, Windows and
    macOS; else for this machine alone, by its own compiler; and where there is none with its sources alone,
    as the standard allows.

    Parameters
    ----------
    model : Model
        The ship in its canal.
    path : str or Path
        Where to, as in ``ship.fmu``.
    fmi : int
        Of the standard: 2 or 3.
    u : float [m/s], optional
        Surge velocity at the start, which an importer may change; what suits the ship unless given.
    dt : float [s], optional
        Longest step of co-simulation; what suits the ship unless given.
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

    Returns
    -------
    tuple of str
        The platforms that it has a library for.

    Raises
    ------
    InputError
        As ``write_c``; where a compiler fails.
    """
    from narrows.export.exported_ship import ExportedShip, prefix_of
    from narrows.export.fmu import fmu_bytes
    from narrows.export.native_build import builds_here
    from narrows.simulation.departure import voyage_defaults
    from narrows.simulation.inputs import finite_numbers
    from narrows.simulation.ship import SimulatedShip

    form_of(path, (".fmu",))
    if fmi not in (2, 3):
        raise InputError(f"fmi = {fmi!r} is no version of the standard; give 2 or 3")
    ship, usual = SimulatedShip(model, surge, surge_inertia, coriolis, contact), voyage_defaults(model, u)
    speed, step = usual.speed if u is None else u, usual.dt if dt is None else dt
    finite_numbers(u=speed, dt=step)
    if not step > 0:
        raise InputError(f"dt = {step:g} s is no step; give a time over 0")
    builds = builds_here(fmi)
    write_whole(path, fmu_bytes(ExportedShip(ship, waterway), prefix_of(path), float(speed), float(step), builds, fmi))
    return tuple(dict.fromkeys(build.folder for build in builds))


def write_page(
    model: "Model", path: str | Path, *, title: str = "", u: float | None = None, surge: "Surge" = "held",
    surge_inertia: float | None = None, coriolis: bool = False, contact: "Contact | Points" = "corners",
) -> tuple[str, ...]:  # fmt: skip
    """Write a model as one HTML page that sails fleets of it in a browser, without a network or a library.

    A fan of thousands of ships in the canal, where they ground, a map of starts and speeds, which way the banks turn
    the bow, sliders for what the terms ask for, and a helm to switch on where there is a rudder. With ziglang (the
    extra ``fmu``) it sails by WebAssembly, one worker a core; without it by the JavaScript of ``write_javascript``.

    Parameters
    ----------
    model : Model
        The ship in its canal.
    path : str or Path
        Where to, as in ``ship.html``.
    title : str
        Of the page; the ship's name unless given.
    u : float [m/s], optional
        Speed that it begins with, which whoever plays may change; what suits the ship unless given.
    surge : str
        ``held``: the speed stays; ``free``: it is integrated.
    surge_inertia : float [kg], optional
        Mass in surge with its added mass, for ``free`` where a_udot was not identifiable.
    coriolis : bool
        Add the rigid body's Coriolis force; the fitted damping at one speed holds it already.
    contact : str or points [m]
        ``corners`` of the hull's rectangle, ``midship`` as in the paper, or an outline of (forward, starboard).

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

    form_of(path, (".html",))
    if contact == OPEN:
        raise InputError("a page shows a canal, and contact 'none' has no banks; choose 'corners'")
    text, notes = assembled(SimulatedShip(model, surge, surge_inertia, coriolis, contact), title, u)
    write_whole(path, text)
    return notes


def _exported(model: "Model", path: str | Path, waterway: "Waterway | None", *choices: Any) -> "ExportedShip":
    from narrows.export.exported_ship import ExportedShip, prefix_of
    from narrows.simulation.ship import SimulatedShip

    return ExportedShip(SimulatedShip(model, *choices), waterway, prefix_of(path))


@dataclass(frozen=True)
class Exporter:
    """A kind of file that a model goes into."""

    words: str  # What it is
    suffixes: tuple[str, ...]  # Of its files
    write: Callable[..., Any]  # Of the model, the path, and whichever options of the others it knows
    # What to say of what was written, by what ``write`` returns
    notes: Callable[[Any], Iterable[str]] = lambda written: ()
    platforms: bool = False  # Whether ``write`` returns the platforms that the file runs on
    refused: Mapping[str, str] = field(default_factory=dict)  # Options that it must not be told, with why


def _about_libraries(platforms: tuple[str, ...]) -> Iterable[str]:
    """Which platforms an FMU has libraries for, and what would make more."""
    from narrows.export.native_build import lacks_zig

    alone = "no compiler is here: the FMU has its sources alone, which importers may compile"
    return [f"libraries for {', '.join(platforms)}" if platforms else alone, *filter(None, [lacks_zig()])]


# What ``narrows export`` writes, by the kind that it is asked for.
EXPORTERS = {
    "c": Exporter("a C99 header", (".h",), write_c),
    "js": Exporter("an ES module", (".mjs", ".js"), write_javascript),
    "python": Exporter("a Python file that needs NumPy alone", (".py",), write_python),
    "bank-force": Exporter(
        "the bank's force as one function in C and C++, C#, JavaScript, MATLAB and Octave",
        (".m", ".h", ".cs", ".mjs"), write_bank_force,
    ),
    "latex": Exporter("the equations of the forces", (".tex",), write_latex),
    "fmu": Exporter("an FMU of FMI 2.0 or 3.0", (".fmu",), write_fmu, _about_libraries, platforms=True),
    "page": Exporter(
        "a page that sails fleets in a browser", (".html",), write_page, tuple,
        refused={"waterway": "a page shows a straight canal; leave --waterway out"},
    ),
}  # fmt: skip
