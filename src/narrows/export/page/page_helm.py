"""The helm of a page: a regulator that can be switched on and off, and a rudder that stays where it is put."""

from narrows.errors import InputError
from narrows.model.model import Model
from narrows.simulation.switched_law import SwitchedLaw


def helm_of(model: Model, speed: float) -> tuple[SwitchedLaw | None, str]:
    """Return what holds a ship in the middle of its canal, or why nothing does."""
    # speed [m/s]
    from narrows.control.regulator import regulator

    if not any(actuator.name == "rudder" for actuator in model.terms.actuators):
        return None, "This model has no rudder: nothing steers."
    try:
        return SwitchedLaw(regulator(model, 0.0, speed)), ""
    except InputError as error:
        return None, f"No helm: {error}."
