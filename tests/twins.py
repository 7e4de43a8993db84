"""Twins of a large container ship in a canal: truths drawn from the covariance of its tests, and their transits."""

import numpy as np

import narrows as nw
from narrows.identification.fitting import bundled_ship
from narrows.logbook.ship_log import SensorGrade
from narrows.logbook.transits import TransitTwin, recorded
from narrows.quantities.names import KNOT
from narrows.simulation.grid import correlated

LENGTH, WIDTH, SPEED = 399.94, 205.0, 8 * KNOT
"""Of the ship and of the canal [m], as in the case of the Suez section, and of the ship [m/s]."""
CURRENT = 0.3
"""Standard deviation of the current along the canal [m/s]."""
MOST_DRAWS = 200


def large_container_ship() -> nw.Model:
    return bundled_ship(LENGTH, WIDTH)


def drawn_truth(model: nw.Model, seed: int, **held: float) -> nw.Model:
    """The first draw of the coefficients that is within the bounds of their terms."""
    names = model.terms.names
    mean = np.array([model.coefficients[name] for name in names])
    bounds = np.array([term.bound for term in model.terms.terms])
    for values in mean + correlated(np.asarray(model.covariance), MOST_DRAWS, (seed, 17)):
        if ((values >= bounds[:, 0] - 1e-9) & (values <= bounds[:, 1] + 1e-9)).all():
            return model.with_coefficients(**{**dict(zip(names, values.tolist(), strict=True)), **held})
    raise nw.InputError("no draw of these coefficients is within the bounds of their terms; identify the model again")


def transits_of(twin: TransitTwin, sensors: SensorGrade, transits: int, seed: int) -> nw.ShipLog:
    """The log of some transits, each in its own gusts and, but in a waterway, its own current."""
    records, current = list[nw.ShipRecord](), 0.0 if twin.waterway else CURRENT
    for number in range(transits):
        own = 1000 * seed + number
        records.append(recorded(f"transit {number + 1}", twin.sailed(own), sensors, own, current))
    return nw.ShipLog(tuple(records), twin.waterway)
