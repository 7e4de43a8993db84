"""What tables of captive tests carry: quantities, each with its unit, and labels."""

from collections.abc import Iterable

from narrows.quantities.names import FORCES, MOTION, PARTICULARS, Quantity
from narrows.ship.actuator import Actuator
from narrows.ship.actuators import STANDARD

# What a table may carry beside its labels, and the SI unit of each.
COLUMNS = {
    **{name: quantity for name, quantity in MOTION.items() if name not in ("cos_psi", "sin_psi")},
    "t": Quantity("s", "time"),
    "psi": Quantity("rad", "heading, clockwise seen from above"),
    **{actuator.name: Quantity(actuator.unit, actuator.meaning) for actuator in STANDARD},
    **{name: PARTICULARS[name] for name in ("draft", "depth", "width")},
    **FORCES,
}


def columns_with(actuators: Iterable[Actuator]) -> dict[str, Quantity]:
    """Return what a table may carry where there are actuators beside those of the package."""
    return {**COLUMNS, **{actuator.name: Quantity(actuator.unit, actuator.meaning) for actuator in actuators}}
