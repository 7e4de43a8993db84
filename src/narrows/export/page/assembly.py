"""A ship made ready for its page: a helm where it has a rudder, WebAssembly where there is a compiler."""

from narrows.errors import InputError
from narrows.export.exported_ship import ExportedShip
from narrows.export.page.page_helm import helm_of
from narrows.export.page.page_text import page_text
from narrows.export.page.wasm_build import SHIP, lacks_zig, wasm_of
from narrows.quantities.names import Number
from narrows.simulation.inputs import finite_numbers
from narrows.simulation.ship import SimulatedShip
from narrows.simulation.steering import steering_of
from narrows.simulation.usual import usual_voyage


def assembled(ship: SimulatedShip, title: str, speed: Number | None) -> tuple[str, tuple[str, ...]]:
    """Return the page of a ship, and what to say of it."""
    # speed [m/s]
    u = float(usual_voyage(ship.model).speed if speed is None else speed)
    finite_numbers(u=u)
    if not u > 0:
        raise InputError(f"u = {u:g} m/s: a page shows ships that make way; give a speed over 0")
    helm, why = helm_of(ship.model, u)
    exported = ExportedShip(ship, None, SHIP, steering_of(helm, ship.actuators))
    lacking = lacks_zig()
    wasm = None if lacking else wasm_of(exported)
    own = title or f"{ship.model.configuration.ship.name} between the banks of a canal: every line is one ship"
    return page_text(exported, u, own, why, wasm), tuple(filter(None, [lacking, why]))
