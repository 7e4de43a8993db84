"""Headers: which column is which quantity, in which unit, and what one of it is in SI."""

import re
from collections.abc import Iterable, Mapping
from functools import cache
from typing import NamedTuple

from narrows.errors import InputError
from narrows.quantities.names import FORCES, MOTION, PARTICULARS, Quantity
from narrows.ship.actuator import Actuator
from narrows.ship.actuators import STANDARD

COLUMNS = {
    **{name: quantity for name, quantity in MOTION.items() if name not in ("cos_psi", "sin_psi")},
    "t": Quantity("s", "time"),
    "psi": Quantity("rad", "heading, clockwise seen from above"),
    **{own.name: Quantity(own.unit, own.meaning) for own in STANDARD},
    **{name: PARTICULARS[name] for name in ("draft", "depth", "width")},
    **FORCES,
}
"""What a table may carry beside its labels, and the SI unit of each."""

LABELS = ("test", "condition")
"""Columns that name things: the test, and the condition (a water depth, say) that it was run under."""

# How headers spell units, where that is not how the units library does.
SPELLINGS = {
    "1": "dimensionless", "°": "deg", "Nm": "N*m", "N m": "N*m", "kNm": "kN*m", "Nmm": "N*mm", "kn": "knot",
    # A revolution is one turn here, and not 2 pi of anything.
    "rpm": "1/minute", "rps": "1/s",
    "mps": "m/s", "mps2": "m/s^2", "degps": "deg/s", "degps2": "deg/s^2", "radps": "rad/s", "radps2": "rad/s^2",
}  # fmt: skip
SUFFIXES = (
    "m",
    "mm",
    "deg",
    "rad",
    "mps",
    "mps2",
    "degps",
    "degps2",
    "radps",
    "radps2",
    "s",
    "N",
    "kN",
    "Nm",
    "rpm",
)


class Column(NamedTuple):
    """A column of the user's table.

    Parameters
    ----------
    header : str
        As in the table.
    quantity : str
        Of the vocabulary.
    scale : float [1]
        How many SI units one of it is.
    stated : bool
        Whether the header carries a unit.
    """

    header: str
    quantity: str
    scale: float
    stated: bool


def columns_with(actuators: Iterable[Actuator]) -> dict[str, Quantity]:
    """Return what a table may carry where there are actuators beside those of the package (ours).

    Parameters
    ----------
    actuators : iterable of Actuator
        The others.
    """
    return {**COLUMNS, **{own.name: Quantity(own.unit, own.meaning) for own in actuators}}


def parse_header(header: str, known: Mapping[str, Quantity] = COLUMNS) -> Column | None:
    """Read one header: ``psi``, ``psi [deg]`` or ``psi_deg`` (ours).

    Parameters
    ----------
    header : str
        As in the table.
    known : mapping of str to Quantity
        What the table may carry.

    Returns
    -------
    Column or None
        None where the header is no quantity of the vocabulary.

    Raises
    ------
    InputError
        Where the unit is unknown or is of another kind than the quantity.
    """
    name, unit = _split(header.strip(), known)
    if name not in known:
        return None
    si = known[name].unit
    return Column(header, name, 1.0 if unit is None else _scale(header, unit, si), unit is not None)


def _split(header: str, known: Mapping[str, Quantity]) -> tuple[str, str | None]:
    if match := re.fullmatch(r"(\w+)\s*\[(.*)\]", header):
        return match[1], match[2].strip()
    name, _, suffix = header.rpartition("_")
    return (name, suffix) if name in known and suffix in SUFFIXES else (header, None)


@cache
def _scale(header: str, unit: str, si: str) -> float:
    import pint

    registry = _registry()
    try:
        parsed, target = (registry(SPELLINGS.get(word, _powers(word))) for word in (unit, si))
        return float((1 * parsed).to(target.units).magnitude)
    except pint.DimensionalityError:
        raise InputError(f"column {header!r}: {unit} is not a unit of this quantity; give it in {si}") from None
    except Exception:  # The units library raises nearly anything on what is no unit.
        raise InputError(f"column {header!r}: unknown unit [{unit}]; give it in [{si}]") from None


def _powers(unit: str) -> str:
    """Spell ``m/s2`` as ``m/s^2``."""
    return re.sub(r"([a-z])(\d)", r"\1^\2", unit).replace("°", "deg")


@cache
def _registry():  # type: ignore[no-untyped-def]
    import pint

    return pint.UnitRegistry()
