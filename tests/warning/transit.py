"""A ship for tests: the KCS at 230 m in a canal 300 m wide that bends, with an estimator of it."""

import math
from dataclasses import replace
from functools import cache

import numpy as np

import narrows as nw
from narrows.estimation import Estimate, Estimator, Gnss, Gyro, Log, RateOfTurn, RudderIndicator
from narrows.identification.fitting import bundled_ship
from narrows.model.tables import table_named
from narrows.waterway import Bank, Centreline

SENSORS = (Gnss(), Gyro(math.radians(0.2)), RateOfTurn(math.radians(0.03)), Log(), RudderIndicator())
SPEED = 4.5


@cache
def ship() -> nw.Model:
    """The KCS at 50 % clearance in a canal as wide as if it had been tested there, with a stated bank.

    Its tests do not determine the bank.
    """
    model = bundled_ship(230.0, 300.0, 16.2, table_named("speed+helm")).with_coefficients(b_bank=-0.1, c_bank=0.1)
    return replace(model, data_range=replace(model.data_range, width_to_beam=None))


@cache
def canal() -> nw.Waterway:
    """A mile straight on, and a gentle bend."""
    s = np.arange(0.0, 6001.0, 20.0)
    heading = np.concatenate([[0.0], np.cumsum(np.where(s[1:] > 3000.0, 20.0 / 5000.0, 0.0))])
    points = np.cumsum(20.0 * np.stack([np.sin(heading), np.cos(heading)], axis=1), axis=0)
    line = Centreline(points)
    ends, half = np.array([0.0, line.length]), np.full(2, 150.0)
    return nw.Waterway(
        line, Bank("starboard", ends, half), Bank("port", ends, half), (ends, np.full(2, 16.2)), name="canal",
        origin=(9.5, 54.2),
    )  # fmt: skip


@cache
def estimator(coefficients: str = "estimated") -> Estimator:
    """One of each kind for all tests."""
    return Estimator(ship(), SENSORS, waterway=canal(), coefficients=coefficients, memory=1.0)


def estimate(y: float, psi: float, x: float = 800.0, seconds: int = 12, coefficients: str = "estimated") -> Estimate:
    """What is known of a ship that was straight on its way to a place for some seconds."""
    one = estimator(coefficients)
    one.forget()
    told = None
    for t in range(seconds):
        back = SPEED * (seconds - 1 - t)
        fix = (x - back * np.cos(psi), y - back * np.sin(psi))
        told = one.update(float(t), {"gnss": fix, "gyro": psi, "rate_of_turn": 0.0, "log": SPEED, "rudder": 0.0})
    assert told is not None
    return told
