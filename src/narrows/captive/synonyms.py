"""Headers that laboratories use for the documented columns, in seven languages."""

import re
import unicodedata
from collections.abc import Mapping

import numpy as np
import pandas as pd

from narrows.captive.tests import LABELS
from narrows.errors import InputError
from narrows.quantities.names import Quantity
from narrows.readers.cells import floats
from narrows.readers.headers import is_unit, parse_header

# In lower case, without accents, units and punctuation.
SYNONYMS = {
    "t": ("time", "elapsed time", "time stamp", "timestamp", "zeit", "tijd", "时间", "temps", "tiempo", "時間"),
    "test": ("run", "run no", "run number", "run id", "test no", "test number", "test id", "test name", "sheet",
             "no", "versuch", "versuchsnummer", "lauf", "proef", "proefnummer", "试验", "试验编号", "工况", "essai",
             "ensayo", "試験番号"),
    "x": ("x position", "longitudinal position", "langsposition", "laengsposition", "纵向位置",
          "position longitudinale", "posicion longitudinal"),
    "y": ("y position", "sway position", "lateral position", "transverse position", "lateral offset",
          "querablage", "querposition", "querversatz", "distance from centreline", "distance from centerline",
          "dwarspositie", "横向位置", "position transversale", "posicion transversal"),
    "psi": ("heading", "heading angle", "yaw angle", "kurswinkel", "gierwinkel", "koers", "koershoek", "ψ", "艏向角",
            "航向角", "航向", "cap", "rumbo", "方位角", "回頭角"),
    "u": ("surge velocity", "surge speed", "longitudinal velocity", "longitudinal speed", "forward speed",
          "langsgeschwindigkeit", "laengsgeschwindigkeit", "langssnelheid", "纵向速度", "vitesse longitudinale",
          "velocidad longitudinal", "前進速度"),
    "v": ("sway velocity", "sway speed", "lateral velocity", "transverse velocity", "quergeschwindigkeit",
          "dwarssnelheid", "横向速度", "vitesse transversale", "velocidad transversal", "横速度"),
    "r": ("yaw rate", "yaw velocity", "rate of turn", "turn rate", "rot", "gierrate", "drehrate",
          "giergeschwindigkeit", "draaisnelheid", "giersnelheid", "艏摇角速度", "转艏角速度", "ψ dot",
          "vitesse de lacet", "velocidad de guinada", "回頭角速度"),
    "udot": ("surge acceleration", "longitudinal acceleration", "u dot", "du dt", "langsbeschleunigung",
             "laengsbeschleunigung", "langsversnelling", "纵向加速度", "acceleration longitudinale",
             "aceleracion longitudinal"),
    "vdot": ("sway acceleration", "lateral acceleration", "transverse acceleration", "v dot", "dv dt",
             "querbeschleunigung", "dwarsversnelling", "横向加速度", "acceleration transversale",
             "aceleracion transversal"),
    "rdot": ("yaw acceleration", "r dot", "dr dt", "gierbeschleunigung", "gierversnelling", "艏摇角加速度", "ψ ddot",
             "acceleration de lacet", "aceleracion de guinada", "回頭角加速度"),
    "heave": ("sinkage", "mean sinkage", "tauchung", "inzinking", "下沉", "下沉量"),
    "X": ("surge force", "longitudinal force", "x force", "fx", "langskraft", "laengskraft", "langskracht", "纵向力",
          "force longitudinale", "fuerza longitudinal", "前後力"),
    "Y": ("sway force", "lateral force", "side force", "transverse force", "y force", "fy", "querkraft",
          "dwarskracht", "横向力", "force transversale", "fuerza transversal", "横力"),
    "N": ("yaw moment", "yawing moment", "n moment", "mz", "giermoment", "艏摇力矩", "转艏力矩", "moment de lacet",
          "momento de guinada", "回頭モーメント"),
    "rudder": ("rudder angle", "ruderwinkel", "ruder", "roerhoek", "roer", "舵角"),
    "revolutions": ("propeller revolutions", "propeller rate", "propeller speed", "shaft speed", "rpm", "drehzahl",
                    "propellerdrehzahl", "toerental", "螺旋桨转速", "转速"),
    "depth": ("water depth", "wassertiefe", "waterdiepte", "水深"),
    "draft": ("draught", "tiefgang", "diepgang", "吃水"),
}  # fmt: skip
NAMES = {word: name for name, words in SYNONYMS.items() for word in words}
# In capitals, where they mean nothing else: U and V may be speeds of the ship, T its draft.
NAMES |= {name: name for name in ("test", "psi", "r", "udot", "vdot", "rdot", "heave", "rudder", "depth")}
# Names that other axes may have, too.
HINTS = {
    "vx": "u",
    "vy": "v",
    "wz": "r",
    "ax": "udot",
    "ay": "vdot",
    "xdot": "u",
    "ydot": "v",
    "u": "u",
    "v": "v",
    "t": "t",
    "n": "N",
    "carriage speed": "u",
}
# Units as such headers write them.
UNIT_WORDS = {
    "grad": "deg", "graden": "deg", "度": "deg", "grad/s": "deg/s", "graden/s": "deg/s", "度/s": "deg/s",
    "grad/s2": "deg/s2", "grad/s²": "deg/s2", "graden/s2": "deg/s2", "graden/s²": "deg/s2", "knoten": "kn",
    "knopen": "kn", "节": "kn", "米": "m", "秒": "s", "牛": "N", "牛·米": "N m", "sek": "s",
}  # fmt: skip


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
    words, unit = unicodedata.normalize("NFKC", header.replace("²", "2")).strip(), ""
    if match := re.fullmatch(r"(.*?)\s*[\[({]([^\])}]*)[\])}](?:\s*[-:,].*)?", words, re.DOTALL):
        words, unit = match[1], match[2].strip()
    elif match := re.fullmatch(r"(.*?)(?:\s*[,/;|]\s*|\s+in\s+|_+|\s+)(\S+)", words):
        last = UNIT_WORDS.get(match[2].lower(), match[2])
        if plain(match[1]) in NAMES and (is_unit(last) or "/" in last):
            words, unit = match[1], last
    return NAMES.get(plain(words), ""), UNIT_WORDS.get(unit.lower(), unit)


def plain(words: str) -> str:
    dotted = unicodedata.normalize("NFKD", words).replace("\u0307", " dot").replace("ψ\u0308", "ψ ddot")
    bare = "".join(letter for letter in dotted if not unicodedata.combining(letter))
    return re.sub(r"[\W_]+", " ", bare.casefold()).strip()


def begun(header: str) -> str:
    """Return the documented name of which each word of a header begins one; empty if none."""
    words = plain(re.sub(r"[\[(].*", "", header))
    parts = words.split()
    if words in HINTS:
        return HINTS[words]
    for known, name in NAMES.items():
        others = known.split()
        begins = [
            any(other.startswith(part) for other in others) or (len(part) > 3 and part in known) for part in parts
        ]
        if len(words) > 2 and all(begins):  # Compounds are written apart, too: "Geschw. längs".
            return name
    return ""
