"""Ship files: TOML with a section for each part of a configuration."""

import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError, did_you_mean, path_of, shown
from narrows.base.files import reading
from narrows.quantities.names import PARTICULARS
from narrows.ship.actuators import SHIP_SECTIONS, Actuator, Part, with_standard
from narrows.ship.particulars import Canal, Configuration, Configured, Ship, Water

# Sections of every configuration; defaults are used if they are absent.
NEEDED = {"ship": Ship, "canal": Canal, "water": Water}
# Least ship file, for messages.
LEAST = "[ship] with length, beam, draft [m], block_coefficient and [canal] with width, depth [m], each on its own line"
NO_SHIP = (
    "a table has no ship of its own; give ship='ship.toml', a Configuration, or {'ship': {'length': ...}, 'canal': "
    "{'width': ...}}, or columns with length, beam, draft, block_coefficient, width, depth [m]"
)
# A ship file or model file, its sections as mappings, its configuration, or a model or tests with one.
ShipSource = str | Path | Configuration | Configured | Mapping[str, Any]


def ship_from(source: ShipSource, actuators: Iterable[Actuator] = ()) -> Configuration:
    if isinstance(source, Configuration | Configured):
        return source if isinstance(source, Configuration) else source.configuration
    if isinstance(source, Mapping):
        return configuration_from(source, "ship", actuators)
    if isinstance(source, Ship):
        if isinstance(whole := vars(source).get("_configuration"), Configuration):
            return whole
        known = "tests.configuration, model.configuration or nw.Configuration(ship, nw.Canal(width))"
        raise InputError(f"ship is a Ship without a canal; give {known} [m]")
    return read_ship(path_of("ship", source), actuators)


@accept_aliases
def read_ship(path: str | Path, actuators: Iterable[Actuator] = ()) -> Configuration:
    """Read a ship file: TOML with [ship], [canal], and optionally [water], [depths] and sections of actuators.

    Raises an InputError if the file is absent, is not TOML, or a key is missing, unknown or out of range.

    Parameters
    ----------
    path : str or Path
        The file.
    actuators : iterable of Actuator
        The user's own actuators, whose sections the file may have.
    """
    if not Path(path).exists():
        raise InputError(
            f"{path}: there is no such ship file (nw.published has the package's ships); check, or write one: {LEAST}"
        )
    return configuration_from(load_toml(path), str(path), actuators)


def actuator_sections(actuators: Iterable[Actuator] = ()) -> dict[str, type[Part]]:
    """Return the class of each section of a file that belongs to an actuator."""
    return {part.SECTION: part for actuator in with_standard(actuators) for part in actuator.parts}


def load_toml(path: str | Path) -> dict[str, Any]:
    with reading(path, "valid TOML"):
        return tomllib.loads(Path(path).read_text(encoding="utf-8-sig"))


def configuration_from(tables: Mapping[str, Any], file: str, actuators: Iterable[Actuator] = ()) -> Configuration:
    """Make a Configuration of the [ship], [canal], [water], [depths] and actuators' tables of a file."""
    sections = actuator_sections(actuators)
    known = {*SHIP_SECTIONS, *sections}
    if "coefficients" in tables:  # A model file, which has the sections of its ship
        tables = {name: tables[name] for name in known & tables.keys()}
    for name, table in tables.items():
        if name not in known:
            raise InputError(f"{file}: unknown section [{name}]{did_you_mean(name, known)}")
        check_table(name, table, file)
    try:
        main = {name: section_of(cls, name, tables.get(name, {})) for name, cls in NEEDED.items()}
        parts = [section_of(cls, name, tables[name]) for name, cls in sections.items() if name in tables]
        assumed = assumptions(main["water"])
        given = {**{name: {} for name in NEEDED}, **tables}
        notes = [note for (name, key), note in assumed.items() if name in given and key not in given[name]]
        return Configuration(**main, depths=dict(tables.get("depths", {})), notes=tuple(notes)).with_parts(parts)
    except InputError as error:
        raise InputError(f"{file}: {error}") from None


def configuration_in(frame: Any, table: str, actuators: Iterable[Actuator] = ()) -> tuple[Configuration, list[str]]:
    """Return the configuration in columns of a table, particulars in SI with one value each, and their names."""
    names = [name for name in ("ship", *PARTICULARS) if name in frame and frame[name].nunique() == 1]
    if not {"length", "beam", "draft", "width"} <= set(names):
        raise InputError(NO_SHIP)
    sizes = {"name" if name == "ship" else name: frame[name].iloc[0] for name in names}
    own = {part: vars(kind)["__dataclass_fields__"].keys() & sizes.keys() for part, kind in NEEDED.items()}
    sections = {part: {n: sizes[n] if n == "name" else float(sizes[n]) for n in own[part]} for part in own}
    return configuration_from(sections, table, actuators), names


def check_same_ship(frame: Any, table: str, given: Configuration) -> None:
    """Raise if the columns of a table that have particulars are of another ship than the given one."""
    own = configuration_in(frame, table)[0].ship
    if own.length != given.ship.length:
        sizes = f"{own.length:.4g} m long, the ship that is given {given.ship.length:.4g} m"
        raise InputError(f"{table}: the ship in its columns is {sizes}; leave the ship out, or the columns")


def assumptions(water: Water) -> dict[tuple[str, str], str]:
    """Return what is assumed where a file leaves a key out, by section and key."""
    return {
        ("water", "density"): f"[water] density is not given: {water.density:g} kg/m3, that of fresh water, is assumed",
        ("propeller", "wake_rate"): "[propeller] wake_rate is not given: the wake of straight running is used in turns",
    }


def check_table(name: str, table: object, file: str) -> None:
    """Raise if a bare value stands in place of a section."""
    if not isinstance(table, Mapping):
        raise InputError(f"{file}: {name} = {shown(table)} must be a section; write [{name}] and its keys under it")


def section_of(cls: type, name: str, values: Mapping[str, Any]) -> Any:
    known = {f.name: f for f in fields(cls)}
    for key in values:
        if key not in known:
            raise InputError(f"[{name}] has an unknown key {key!r}{did_you_mean(key, known)}")
    missing = [key for key, entry in known.items() if entry.default is MISSING and key not in values]
    if missing:
        raise InputError(f"[{name}] lacks {', '.join(missing)}; add it in SI units")
    return cls(**values)
