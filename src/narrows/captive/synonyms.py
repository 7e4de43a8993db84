"""Headers that laboratories use for the documented columns, in seven languages: ``synonyms.toml``."""

import re
import tomllib
import unicodedata
from collections.abc import Mapping
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd

from narrows.captive.tests import LABELS
from narrows.errors import InputError
from narrows.quantities.names import Quantity
from narrows.readers.cells import floats
from narrows.readers.headers import is_unit, parse_header


@cache
def _meanings(section: str) -> dict[str, str]:
    """Meaning of each word: a documented name, or a unit."""
    tables = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))
    found = {word: name for name, words in tables[section].items() for word in words}
    # In capitals, where they mean nothing else: U and V may be speeds of the ship, T its draft.
    alone = ("test", "psi", "r", "udot", "vdot", "rdot", "heave", "rudder", "depth")
    return found | dict(zip(alone, alone, strict=True)) if section == "names" else found


def renamed(frame: pd.DataFrame, known: Mapping[str, Quantity], table: str) -> tuple[pd.DataFrame, tuple[str, ...]]:
    """Return a table whose headers of other words are the documented ones, and what was taken for what."""
    headers = [str(header) for header in frame.columns]
    present = {name for header in headers if (name := _documented(header, known))}
    new: dict[str, str] = {}
    for header in headers:
        name, unit = meant(header)
        if not name or name in present or _documented(header, known):
            continue
        first = next((old for old, other in new.items() if other.partition(" ")[0] == name), "")
        if first:
            raise InputError(f"{table}: {first!r} and {header!r} may both be {name}; head the right one {name!r}")
        new[header] = f"{name} [{unit}]" if unit and name not in LABELS else name
    if not new:
        return frame, ()
    turns = "r" in present or any(name.partition(" ")[0] == "r" for name in new.values())
    for header, name in new.items():
        if (name == "rudder" or (name == "psi" and not turns)) and np.any(floats(frame[header]) != 0):
            raise InputError(f"{table}: column {header!r} has no unit; head it '{name} [deg]' or '{name} [rad]'")
    said = "; ".join(f"{other} is {header!r}" for header, other in new.items())
    return frame.rename(columns=new), (f"by their headers: {said}",)


def _documented(header: str, known: Mapping[str, Quantity]) -> str:
    if header in LABELS:
        return header
    try:
        column = parse_header(header, known)
    except InputError:  # An unknown unit: its reader raises.
        return header
    return column.quantity if column else ""


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
        begins = [
            any(other.startswith(part) for other in others) or (len(part) > 3 and part in known) for part in parts
        ]
        if len(words) > 2 and all(begins):  # Compounds are written apart, too: "Geschw. längs".
            return name
    return ""
