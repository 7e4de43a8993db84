"""A kind of exported file, and code that exporters share."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from narrows.errors import InputError
from narrows.waterway.current_profile import check_along_only

if TYPE_CHECKING:
    from narrows.export.exported_ship import ExportedShip
    from narrows.model.model import Model
    from narrows.waterway.waterway import Waterway


@dataclass(frozen=True)
class Exporter:
    """One export format; each module in ``exporters`` defines it as ``EXPORTER``."""

    kind: str  # Name in ``narrows export``
    words: str  # Description
    suffixes: tuple[str, ...]  # Suffixes of its files
    write: Callable[..., Any]  # Takes the model, the path, and those of the other options that it accepts
    # Notes on the written file, from the result of ``write``
    notes: Callable[[Any], Iterable[str]] = lambda written: ()
    platforms: bool = False  # True if ``write`` returns the platforms that the file runs on
    refused: Mapping[str, str] = field(default_factory=dict)  # Options that it refuses, with the reason


def ship_to_export(
    model: "Model", path: str | Path, waterway: "Waterway | None", *choices: Any, controller: Any = None
) -> "ExportedShip":
    """Return a ship under its choices with its control law; names begin with that of the file."""
    from narrows.export.exported_ship import ExportedShip, prefix_of
    from narrows.simulation.controllers import ControlLaw
    from narrows.simulation.ship import SimulatedShip
    from narrows.simulation.steering import steering_of

    if controller is not None and not isinstance(controller, ControlLaw):
        raise InputError(
            f"a {type(controller).__name__} runs in Python alone; export a law in arithmetic, such as a regulator"
        )
    if waterway is not None:
        check_along_only(waterway, "a file")
    ship = SimulatedShip(model, *choices)
    return ExportedShip(ship, waterway, prefix_of(path), steering_of(controller, ship.actuators))


def check_standard(fmi: int) -> None:
    """Refuse an unknown version of FMI."""
    if fmi not in (2, 3):
        raise InputError(f"fmi = {fmi!r} is no version of the standard; give 2 or 3")
