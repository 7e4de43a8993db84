"""Columns of captive-test tables, headers of laboratories that mean them (``synonyms.toml``), drafts of a mapping."""

import json
import math
import re
import tomllib
import unicodedata
from collections.abc import Container, Iterable, Mapping
from dataclasses import MISSING, fields
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from narrows.base.errors import InputError, near_miss
from narrows.quantities.names import FORCES, MOTION, PARTICULARS, Quantity, is_unit, unit_named
from narrows.readers.cells import Vocabulary, floats, quantity_of, split_header
from narrows.readers.text_table import seen
from narrows.ship.actuators import STANDARD, Actuator, particulars_with, places_of, with_standard
from narrows.ship.particulars import Canal, Ship, Water


class Headers(NamedTuple):
    """Headers of a table that were not read, for messages about missing columns."""

    table: str = ""  # The file; empty for none
    unread: tuple[str, ...] = ()  # Headers that are no quantity


# Columns of words in a table of tests.
LABELS = ("test", "condition")
# Headers of tests without a table.
NO_TABLE = Headers()

# Quantities of a table besides its labels, and the SI unit of each.
COLUMNS = {
    **{name: quantity for name, quantity in MOTION.items() if name not in ("cos_psi", "sin_psi")},
    "t": Quantity("s", "time"),
    "psi": Quantity("rad", "heading, clockwise seen from above"),
    **{actuator.name: Quantity(actuator.unit, actuator.meaning) for actuator in STANDARD},
    **{name: PARTICULARS[name] for name in ("draft", "depth", "width")},
    **FORCES,
}


def columns_with(actuators: Iterable[Actuator]) -> dict[str, Quantity]:
    return {**COLUMNS, **{actuator.name: Quantity(actuator.unit, actuator.meaning) for actuator in actuators}}


def check_given(asked: Iterable[str], values: Container[str], headers: Headers, actuators: Iterable[Actuator]) -> None:
    """Raise if terms need a quantity that neither the table nor its ship file gives."""
    movers = with_standard(actuators)
    column = {word: actuator.name for actuator in movers for word in actuator.controls}
    column |= {"cos_psi": "psi", "sin_psi": "psi"}
    missing = list(dict.fromkeys(column.get(name, name) for name in asked if name not in values))
    if missing:
        raise InputError(f"{_lacking(missing[0], headers, movers)}{_others(missing[1:], movers)}")


def _others(names: Iterable[str], movers: Iterable[Actuator]) -> str:
    """Name what else is missing, as the ship file has it; what has a default need not be given."""
    parts = [part for mover in movers for part in mover.parts]
    usual = {part.known_as(one.name) for part in parts for one in fields(part) if one.default is not MISSING}
    places, found = _places(movers), dict[str, list[str]]()
    for name in names:
        section, _, key = places.get(name, f"column {name}").partition(" ")
        if name not in usual:
            found.setdefault(section, []).append(key)
    more = "; ".join(f"{section} {', '.join(keys)}" for section, keys in found.items())
    return f"; missing too: {more}" if more else ""


def _places(movers: Iterable[Actuator]) -> dict[str, str]:
    sections: dict[str, type] = {"ship": Ship, "canal": Canal, "water": Water}
    own = {field.name: f"[{section}] {field.name}" for section, part in sections.items() for field in fields(part)}
    return own | places_of(movers)


def _lacking(name: str, headers: Headers, movers: tuple[Actuator, ...]) -> str:
    known = columns_with(movers)
    if name not in known or name in PARTICULARS:
        section, _, key = _places(movers).get(name, "").partition(" ")
        unit, meaning = particulars_with(movers).get(name, ("1", ""))
        where = f"{key}{'' if unit == '1' else f' [{unit}]'} to section {section} of the ship file: {meaning}"
        said = f"the terms need {name}, which neither the tests nor the ship file give"
        return f"{said}; add {where if section and meaning else 'it'}"
    unit, meaning = known[name]
    table = f"{headers.table}: " if headers.table else ""
    near = near_miss(name, headers.unread)
    unread = f", or say by --mapping which of {seen(headers.unread)} it is" if headers.unread and not near else near
    drift = next((header for header in headers.unread if re.search("drift|beta", header.lower())), None)
    if name in ("u", "v") and drift:
        unread = f": u = U cos(beta) and v = -U sin(beta), if {drift!r} is beta, positive with the bow to starboard"
    return f"{table}column {name!r} is missing ({meaning} [{unit}]); add it{unread}"


@cache
def _meanings(section: str) -> dict[str, str]:
    """Meaning of each word: a documented name, or a unit."""
    tables = tomllib.loads(Path(__file__).with_name("synonyms.toml").read_text(encoding="utf-8"))
    found = {word: name for name, words in tables[section].items() for word in words}
    # In capitals, where they mean nothing else: U and V may be speeds of the ship, T its draft.
    alone = ("test", "psi", "r", "udot", "vdot", "rdot", "heave", "rudder", "depth")
    return found | dict(zip(alone, alone, strict=True)) if section == "names" else found


def renamed(frame: pd.DataFrame, known: Mapping[str, Quantity], table: str) -> tuple[pd.DataFrame, tuple[str, ...]]:
    """Return a table whose headers of other words are the documented ones, and what was taken for what."""
    documented = {str(header): quantity_of(str(header), Vocabulary(known, LABELS)) for header in frame.columns}
    new: dict[str, str] = {}
    for header in documented:
        name, unit = meant(header)
        if not name or documented[header] or name in documented.values():
            continue
        if first := next((old for old, other in new.items() if other.partition(" ")[0] == name), ""):
            raise InputError(f"{table}: {first!r} and {header!r} may both be {name}; head the right one {name!r}")
        new[header] = f"{name} [{unit}]" if unit and name not in LABELS else name
    if not new:
        return frame, ()
    turns = "r" in {*documented.values(), *(name.partition(" ")[0] for name in new.values())}
    for header, name in new.items():
        if (name == "rudder" or (name == "psi" and not turns)) and np.any(floats(frame[header]) != 0):
            raise InputError(f"{table}: column {header!r} has no unit; head it '{name} [deg]' or '{name} [rad]'")
    said = "; ".join(f"{other} is {header!r}" for header, other in new.items())
    return frame.rename(columns=new), (f"by their headers: {said}",)


def meant(header: str) -> tuple[str, str]:
    """The documented name that a header means, and its unit; empty where it means none, or has none."""
    names, units = _meanings("names"), _meanings("units")
    words, unit = unicodedata.normalize("NFKC", header.replace("²", "2")).strip(), ""
    if match := re.fullmatch(r"(.*?)\s*[\[({]([^\])}]*)[\])}](?:\s*[-:,].*)?", words, re.DOTALL):
        words, unit = match[1], match[2].strip()
    elif match := re.fullmatch(r"(.*?)(?:\s*[,/;|]\s*|\s+in\s+|_+|\s+)(\S+)", words):
        last = units.get(match[2].lower(), match[2])
        if plain(match[1]) in names and (is_unit(last) or "/" in last):
            words, unit = match[1], last
    return names.get(plain(words), ""), units.get(unit.lower(), unit)


def plain(words: str) -> str:
    dotted = unicodedata.normalize("NFKD", words).replace("\u0307", " dot").replace("ψ\u0308", "ψ ddot")
    bare = "".join(letter for letter in dotted if not unicodedata.combining(letter))
    return re.sub(r"[\W_]+", " ", bare.casefold()).strip()


def begun(header: str) -> str:
    """Return the documented name of which each word of a header begins one; empty if none."""
    words = plain(re.sub(r"[\[(].*", "", header))
    parts = words.split()
    if name := _meanings("hints").get(words):
        return name
    for known, name in _meanings("names").items():
        others = known.split()
        begins = (any(it.startswith(part) for it in others) or (len(part) > 3 and part in known) for part in parts)
        if len(words) > 2 and all(begins):  # Compounds are written apart, too: "Geschw. längs".
            return name
    return ""


def draft_columns(frame: pd.DataFrame, table: str, command: str) -> str:
    """Draft ``columns.toml`` for a table whose headers are not all recognised, by their words; empty without any."""
    documented = {str(header): quantity_of(str(header), Vocabulary(COLUMNS, LABELS)) for header in frame.columns}
    for header in documented:
        if (unit := split_header(header)[1]) and unit_named(unit) is None:
            documented[header] = ""
    unread = [header for header, name in documented.items() if not name]
    columns, units = dict[str, str](), dict[str, str]()
    # Synonyms come before guesses, in which each word begins one of a synonym.
    for header, (meaning, stated) in sorted(((h, meant(h)) for h in unread), key=lambda found: not found[1][0]):
        name = meaning or begun(header)
        if not name or name in columns or name in documented.values():
            continue
        unread.remove(header)
        own = split_header(header)[1]
        unit, remark = _drafted_unit(name, stated or own, floats(frame[header]))
        sure = "sure" if meaning and not remark.endswith("?") else "GUESSED"
        why = f"  # {sure}: {' '.join(f'{header!r} is {name}{remark}'.split())}"
        columns[name] = f"{name} = {json.dumps(header, ensure_ascii=False)}{why}"
        if unit != own:
            units[name] = f"{name} = {json.dumps(unit, ensure_ascii=False)}{why}"
    if not columns:
        return ""
    return "\n".join([
        f"# Columns of {table}, drafted. Check the lines with GUESSED, then type:", f"#   {command}",
        "# With true here, narrows identify reads it for every table of this folder.", "confirmed = false",
        "", "[columns]", *columns.values(),
        *(f"# not used: {json.dumps(header, ensure_ascii=False)}" for header in unread),
        *(["", "[units]", *units.values()] if units else ()), "",
    ])  # fmt: skip


def _drafted_unit(name: str, stated: str, values: np.ndarray) -> tuple[str, str]:
    """The unit of a header or, of an angle without one, by its size, and a remark on the latter."""
    if name in LABELS:
        return "", ""
    given, wanted = unit_named(stated) if stated else None, unit_named(COLUMNS[name].unit)
    if given and wanted and given.powers == wanted.powers:
        return stated, ""
    most, si = float(np.nanmax(np.abs(values), initial=0.0)), COLUMNS[name].unit
    if not most or not si.startswith("rad"):
        return "", ""
    if most > math.pi / 2:
        return si.replace("rad", "deg"), f"; up to {most:.3g}, too large for radians"
    return si, f"; up to {most:.3g}, degrees or radians?"
