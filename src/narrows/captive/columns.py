"""Columns of captive-test tables, and headers of laboratories that mean them (``synonyms.toml``)."""

import re
import tomllib
import unicodedata
from collections.abc import Container, Iterable, Mapping
from dataclasses import MISSING, fields
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd

from narrows.base.errors import InputError, near_miss
from narrows.captive.tests import LABELS, Headers
from narrows.quantities.dimensions import is_unit
from narrows.quantities.names import FORCES, MOTION, PARTICULARS, Quantity
from narrows.readers.cells import Vocabulary, floats, quantity_of
from narrows.readers.text_table import seen
from narrows.ship.actuators import STANDARD, Actuator, particulars_with, places_of
from narrows.ship.particulars import Canal, Ship, Water

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


SOURCE = "Yasukawa and Yoshimura 2015"


def check_given(asked: Iterable[str], values: Container[str], headers: Headers, actuators: Iterable[Actuator]) -> None:
    """Raise if terms need a quantity that neither the table nor its ship file gives."""
    missing = [name for name in asked if name not in values]
    if not missing:
        return
    movers = (*STANDARD, *actuators)
    column = {word: actuator.name for actuator in movers for word in actuator.controls}
    column |= {"cos_psi": "psi", "sin_psi": "psi"}
    first, *more = dict.fromkeys(column.get(name, name) for name in missing)
    raise InputError(f"{_lacking(first, missing[0], headers, movers)}{_others(more, movers)}")


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


def _lacking(wanted: str, name: str, headers: Headers, movers: tuple[Actuator, ...]) -> str:
    known = columns_with(movers)
    if wanted not in known or wanted in PARTICULARS:
        section, _, key = _places(movers).get(name, "").partition(" ")
        unit, meaning = particulars_with(movers).get(name, ("1", ""))
        where = f"{key}{'' if unit == '1' else f' [{unit}]'} to section {section} of the ship file: {meaning}"
        said = f"the terms need {name}, which neither the tests nor the ship file give"
        return f"{said}; add {where if section and meaning else 'it'}{usual(name)}"
    unit, meaning = known[wanted]
    table = f"{headers.table}: " if headers.table else ""
    near = near_miss(wanted, headers.unread)
    unread = f", or say by --mapping which of {seen(headers.unread)} it is" if headers.unread and not near else near
    drift = next((header for header in headers.unread if re.search("drift|beta", header.lower())), None)
    if wanted in ("u", "v") and drift:
        unread = f": u = U cos(beta) and v = -U sin(beta), if {drift!r} is beta, positive with the bow to starboard"
    return f"{table}column {wanted!r} is missing ({meaning} [{unit}]); add it{unread}"


def usual(name: str) -> str:
    """Return a particular of a published ship, with the source, in words; nothing if there is none."""
    from narrows.empirical.fleet import published

    example = published("yasukawa2015_kvlcc2").configuration
    values, size = example.values(), f"{example.ship.length:g} m long"
    if name == "flow_straightening":
        low, high = (values[f"rudder_straightening_{side}"] for side in ("port", "starboard"))
        return f"; usual are {low:.2g} to {high:.2g}, those of KVLCC2 to port and to starboard ({SOURCE})"
    asked = name.startswith(("rudder_", "propeller_")) or name in ("x_g", "inertia", "mass", "revolutions")
    return f"; KVLCC2, {size}, has {values[name]:.4g} ({SOURCE})" if asked and name in values else ""


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
