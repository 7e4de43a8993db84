"""An envelope of a million points beside one voyage after another, and a million positions to a waterway and back.

python benchmarks/envelope.py [DRAWS] [--small]
"""

import time
from dataclasses import replace

import numpy as np
from common import median_seconds, show, sizes
from scipy.optimize import root

import narrows as nw
from narrows.identification.fitting import bundled_ship
from narrows.model.tables import table_named
from narrows.safety.request import Disturbance
from narrows.safety.settings import STEPS_A_LENGTH, TRIAL_LENGTHS
from narrows.safety.trials import trials
from narrows.waterway import Centreline, Waterway
from narrows.waterway.banks import Bank

OFFSETS, SPEEDS = np.linspace(-60, 60, 41), np.linspace(2.0, 7.0, 25)


def full_scale() -> nw.Model:
    """The KCS at 50 % clearance, 230 m long in a canal 300 m wide."""
    return bundled_ship(230.0, 300.0, 16.2, table_named("speed+helm"))


def one_by_one(model: nw.Model, y: float, u: float) -> None:
    """SciPy's root finder on the terms, then a voyage in plain Python under the autopilot."""

    def off(z: np.ndarray) -> np.ndarray:
        found = model.forces(nw.Motion.at(-np.arctan(z[0]), y=y, u=u, v=u * z[0]), z[1])
        return np.array([found["Y"] / 1e6, found["N"] / 1e8])

    drift, rudder = root(off, [0.0, 0.0]).x
    helm = nw.control.regulator(model, y, u)
    line = replace(helm.lines[0], rudder=rudder, psi=-np.arctan(drift), v=u * drift)
    pilot = replace(helm, lines=(line,))
    length = model.configuration.ship.length
    nw.simulate(
        model, y=y, u=u, psi=-np.arctan(drift) + 0.03, v=u * drift, rudder=rudder, controller=pilot,
        duration=TRIAL_LENGTHS * length / u, dt=length / (STEPS_A_LENGTH * u),
    )  # fmt: skip


def winding() -> Waterway:
    """20 km of a river."""
    t = np.linspace(0, 20_000, 60)
    line = Centreline(np.stack([600 * np.sin(t / 2500), t], axis=1))
    s = np.array([0.0, line.length])
    return Waterway(line, Bank("starboard", s, np.full(2, 100.0)), Bank("port", s, np.full(2, 100.0)))


def main(draws: int, poses: int) -> None:
    """Measure and print."""
    model, calm = full_scale(), np.zeros(len(SPEEDS))
    # One pilot, as one by one; an answer tries another beside it, who knows each ship.
    trials(model, OFFSETS[:2], SPEEDS[:2], calm[:2], Disturbance(), 2, 0, knowing=False)
    start = time.perf_counter()
    points = trials(model, OFFSETS, SPEEDS, calm, Disturbance(), draws, 0, knowing=False)["held"].size
    each = (time.perf_counter() - start) / points
    alone = median_seconds(lambda: one_by_one(model, 20.0, 5.0), 3)
    rows = [("narrows", each, f"{points} points in {each * points:.1f} s"), ("one by one, plain Python", alone, "")]
    show("a point of the envelope: steady course and trial", rows, "us", 1e6)

    way, draw = winding(), np.random.default_rng(0)
    s, n, psi = (draw.uniform(*ends, poses) for ends in ((0, way.line.length), (-90, 90), (-1, 1)))
    positions, heading = way.to_map(s, n, psi)
    rows = [
        ("to the waterway", median_seconds(lambda: way.to_channel(positions, heading), 3), ""),
        ("to the map", median_seconds(lambda: way.to_map(s, n, psi), 3), ""),
        ("there and back", median_seconds(lambda: way.to_channel(*way.to_map(s, n, psi)), 3), ""),
    ]
    show(f"{poses} poses", rows, "s", 1.0)


if __name__ == "__main__":
    draws, small = sizes(__doc__, usual=1000, small=2)
    main(draws, poses=10**4 if small else 10**6)
