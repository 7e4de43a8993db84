"""Every export format: a function that writes it, and its row in ``EXPORTERS``."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from narrows.aliases import accept_aliases
from narrows.errors import InputError
from narrows.files import form_of, write_whole
from narrows.waterway.current_profile import check_along_only

if TYPE_CHECKING:
    from narrows.codegen.free_motion import Surge
    from narrows.export.exported_ship import ExportedShip
    from narrows.model.model import Model
    from narrows.simulation.controllers import ControlLaw
    from narrows.simulation.inputs import Contact
    from narrows.simulation.ship import Points
    from narrows.waterway.waterway import Waterway


@dataclass(frozen=True)
class Exporter:
    """One export format; one row of ``EXPORTERS``."""

    kind: str  # Name in ``narrows export``
    words: str  # Description
    suffixes: tuple[str, ...]  # Suffixes of its files
    write: Callable[..., Any]  # Takes the model, the path, and those of the other options that it accepts
    # Notes on the written file, from the result of ``write``
    notes: Callable[[Any], Iterable[str]] = lambda written: ()
    platforms: bool = False  # True if ``write`` returns the platforms that the file runs on
    refused: Mapping[str, str] = field(default_factory=dict)  # Options that it refuses, with the reason


@accept_aliases
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

    form_of(path, EXPORTERS["bank-force"].suffixes)
    check_standard(fmi)
    fmu = Path(path).suffix == ".fmu"
    write_whole(path, force_fmu(model, prefix_of(path), fmi) if fmu else force_text(model, path, prefix_of(path)))


@accept_aliases
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

    form_of(path, EXPORTERS["c"].suffixes)
    ship = ship_to_export(model, path, waterway, surge, surge_inertia, coriolis, contact, controller=controller)
    write_whole(path, cpp_text(ship) if Path(path).suffix == ".hpp" else c_text(ship))


@accept_aliases
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

    form_of(path, EXPORTERS["fmu"].suffixes)
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


@accept_aliases
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

    form_of(path, EXPORTERS["js"].suffixes)
    ship = ship_to_export(model, path, waterway, surge, surge_inertia, coriolis, contact, controller=controller)
    write_whole(path, npm_bytes(ship) if Path(path).suffix == ".tgz" else javascript_text(ship))


def write_latex(model: "Model", path: str | Path) -> None:
    """Write the equations of the forces, once with symbols and once with the numbers of a model, and its particulars.

    It needs the LaTeX package amsmath.

    Parameters
    ----------
    model : Model
        The ship in its canal.
    path : str or Path
        Output file, as in ``ship.tex``.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    from narrows.codegen.printers.latex import Equations, environment
    from narrows.export.exported_ship import ExportedShip
    from narrows.export.passport import passport
    from narrows.export.rendering import commented
    from narrows.quantities.names import FORCES
    from narrows.simulation.ship import SimulatedShip

    form_of(path, EXPORTERS["latex"].suffixes)
    about = [*passport(model), ExportedShip(SimulatedShip(model)).bottom_note]
    lines = [f"% {commented(line)}" for line in about]
    written = Equations(model.terms)
    by_symbols = [*written.of_forces(tuple(FORCES)), *written.definitions()]
    by_numbers = written.of_forces(tuple(FORCES), model.coefficients)
    numbers = written.values(model.configuration.values())
    # Pages break between lines.
    parts = [environment("align*", one) for one in (by_symbols, by_numbers, numbers) if one]
    write_whole(path, "\n".join([*lines, "{\\allowdisplaybreaks", *parts, "}"]) + "\n")


@accept_aliases
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

    form_of(path, EXPORTERS["matlab"].suffixes)
    ship = ship_to_export(model, path, None, surge, surge_inertia, coriolis, "corners")
    write_whole(path, simulink_text(ship) if Path(path).suffix == ".c" else matlab_text(ship))


@accept_aliases
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

    form_of(path, EXPORTERS["page"].suffixes)
    if contact == "none":
        raise InputError("a page shows a canal, and contact 'none' has no banks; choose 'corners'")
    text, notes = assembled(SimulatedShip(model, surge, surge_inertia, coriolis, contact), title, u)
    write_whole(path, text)
    return notes


@accept_aliases
def write_python(
    model: "Model", path: str | Path, *, waterway: "Waterway | None" = None, surge: "Surge" = "held",
    surge_inertia: float | None = None, coriolis: bool = False, contact: "Contact | Points" = "corners",
    controller: "ControlLaw | None" = None,
) -> None:  # fmt: skip
    """Write a model as one Python file that needs NumPy alone: the content of ``write_c``, also for columns of ships.

    The parameters and refusals are those of ``write_c``.
    """
    from narrows.export.ship_files import python_text

    form_of(path, EXPORTERS["python"].suffixes)
    ship = ship_to_export(model, path, waterway, surge, surge_inertia, coriolis, contact, controller=controller)
    write_whole(path, python_text(ship))


def ship_to_export(
    model: "Model", path: str | Path, waterway: "Waterway | None", *choices: Any, controller: Any = None
) -> "ExportedShip":
    """Return a ship under its choices with its control law; names begin with that of the file."""
    from narrows.export.exported_ship import ExportedShip, prefix_of
    from narrows.simulation.controllers import ControlLaw
    from narrows.simulation.ship import SimulatedShip
    from narrows.simulation.steering import steering_of

    if controller is not None and not isinstance(controller, ControlLaw):
        raise InputError(
            f"a {type(controller).__name__} runs in Python alone; export a law in arithmetic, such as a regulator"
        )
    if waterway is not None:
        check_along_only(waterway, "a file")
    ship = SimulatedShip(model, *choices)
    return ExportedShip(ship, waterway, prefix_of(path), steering_of(controller, ship.actuators))


def check_standard(fmi: int) -> None:
    """Refuse an unknown version of FMI."""
    if fmi not in (2, 3):
        raise InputError(f"fmi = {fmi!r} is no version of the standard; give 2 or 3")


_ROWS = (
    Exporter(
        "bank-force", "the bank's force as one function in C and C++, C#, JavaScript, MATLAB and Octave, or as an FMU",
        (".m", ".h", ".cs", ".mjs", ".fmu"), write_bank_force,
        refused={"waterway": "the bank's force takes the section as input; leave --waterway out"},
    ),
    Exporter("c", "a header of C99 and C++, or one with a class", (".h", ".hpp"), write_c),
    Exporter("fmu", "an FMU of FMI 2.0 or 3.0", (".fmu",), write_fmu, about_libraries, platforms=True),
    Exporter("js", "an ES module, or an npm package of it with types", (".mjs", ".js", ".tgz"), write_javascript),
    Exporter("latex", "the equations of the forces", (".tex",), write_latex),
    Exporter(
        "matlab", "a function of MATLAB and Octave in the form of MSS, or an S-function", (".m", ".c"), write_matlab,
        refused={"waterway": "a function of MATLAB has the canal of its model; leave --waterway out"},
    ),
    Exporter(
        "page", "a page that sails fleets in a browser", (".html",), write_page, tuple,
        refused={"waterway": "a page shows a straight canal; leave --waterway out"},
    ),
    Exporter("python", "a Python file that needs NumPy alone", (".py",), write_python),
)  # fmt: skip
# Formats of ``narrows export``, by name.
EXPORTERS: dict[str, Exporter] = {own.kind: own for own in _ROWS}
