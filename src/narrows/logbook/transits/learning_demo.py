"""A demonstration without a log: twins of transits of a large container ship, whose truth is known."""

from dataclasses import dataclass, replace

from narrows.errors import InputError
from narrows.identification.bundled_ship import bundled_ship
from narrows.logbook.sensor_grades import SensorGrade
from narrows.logbook.ship_log import ShipLog
from narrows.logbook.transits.transit_twins import TransitTwin, drawn_truth, recorded
from narrows.model.model import Model
from narrows.progress import bar, is_shown
from narrows.quantities.constants import KNOT

# Of the ship and the canal [m], as in the case of the Suez section.
LENGTH, WIDTH = 399.94, 205.0
# Of a transit, and of one for a demonstration that is soon over.
SPEED, MINUTES, SHORT_MINUTES = 8 * KNOT, 40.0, 20.0
# That may be drawn until one comes through.
SHIPS = 100


@dataclass(frozen=True)
class DemonstratedLog:
    """Transits of a ship whose truth is known."""

    prior: Model  # The ship as its captive tests tell
    truth: Model  # What it is
    log: ShipLog  # What its sensors recorded


def large_container_ship() -> Model:
    """Return the KCS as identified from the bundled tests, at 400 m in a canal of 205 m."""
    return bundled_ship(LENGTH, WIDTH)


def demonstrated_log(sensors: SensorGrade, transits: int = 10, seed: int = 1) -> DemonstratedLog:
    """Return twins of transits of a ship that its tests leave possible."""
    prior = large_container_ship()
    for ship in range(SHIPS):
        truth = drawn_truth(prior, SHIPS * seed + ship)
        try:
            twin = TransitTwin(truth, SPEED, 60 * SHORT_MINUTES)
            return DemonstratedLog(prior, truth, transits_of(truth, sensors, transits, SHIPS * seed + ship, twin))
        except InputError:
            continue
    raise InputError("none of the ships that were drawn comes through the canal; take another seed")


def transits_of(
    truth: Model, sensors: SensorGrade, transits: int, seed: int, twin: TransitTwin | None = None
) -> ShipLog:
    """Return transits of a ship as its sensors record them."""
    usual = replace(twin, truth=truth) if twin else TransitTwin(truth, SPEED, 60 * MINUTES)
    records = []
    with bar(transits, is_shown(), "transits") as done:
        for number in range(transits):
            voyage = usual.sailed(1000 * seed + number)
            drawn = {"current": 0.0} if usual.waterway else {}  # A waterway has its own.
            records.append(recorded(f"transit {number + 1}", voyage, sensors, 1000 * seed + number, **drawn))
            done(1)
    return ShipLog(tuple(records), usual.waterway)
