"""Quantities as the package's vocabulary has them: names, units, meanings."""

from collections.abc import Mapping

from _extension.markdown import table
from narrows.captive.columns import COLUMNS
from narrows.quantities.names import FORCES, MOTION, PARTICULARS, Quantity
from narrows.ship.actuators import STANDARD

USUAL_UNITS = {
    "m": ("mm", "cm"), "m/s": ("mm/s", "kn"), "m/s2": ("mm/s2",), "rad": ("deg", "°"), "rad/s": ("deg/s", "°/s"),
    "rad/s2": ("deg/s2",), "N": ("kN",), "N m": ("Nm", "kNm", "N*m", "Nmm"), "1/s": ("rpm", "rps"),
}  # fmt: skip


def _rows(quantities: Mapping[str, Quantity]) -> str:
    return table(
        ("name", "unit", "meaning"),
        ((f"`{name}`", quantity.unit, quantity.meaning) for name, quantity in quantities.items()),
    )


def motion() -> str:
    """Where the ship is and how it moves."""
    return _rows(MOTION)


def particulars() -> str:
    """The ship, the canal and the water."""
    return _rows(PARTICULARS)


def forces() -> str:
    """What is measured, and what a model gives."""
    return _rows(FORCES)


def actuators() -> str:
    """Rudder and propeller: their positions, and what terms may ask of each."""
    return "\n\n".join(
        f"**{actuator.name}**: {actuator.meaning} [{actuator.unit}]\n\n{_rows(actuator.quantities)}"
        for actuator in STANDARD
    )


def columns() -> str:
    """Columns of tables of tests, and the units that they usually come in."""
    return table(
        ("column", "SI unit", "other units", "meaning"),
        (
            (f"`{name}`", quantity.unit, ", ".join(USUAL_UNITS.get(quantity.unit, ())), quantity.meaning)
            for name, quantity in COLUMNS.items()
        ),
    )
