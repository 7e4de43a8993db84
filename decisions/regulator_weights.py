"""The usual weights of the regulator: tuned by flights of the KCS at full size, with a gear, at two sizes of doubt.

The KCS of 230 m is flown as its tests know it, and with 2.5 times the standard deviations of its coefficients, which is
about what is known of a ship without tests of its own. Doubts of both sizes count, those of the tests twice. The gear
has 1 s of dead time and 1.5 s of lag. What is printed is rounded by hand into ``RegulatorWeights``.

python decisions/regulator_weights.py
"""

import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

import narrows as nw
from narrows.control.design import SCENES, TUNED, cost_of, searched, weights_at, with_gear
from narrows.control.flights import Flights
from narrows.control.regulator_gains import USUAL

sys.path.append(str(Path(__file__).parent.parent / "benchmarks"))
from envelope import full_scale

HOLD, SPEED, GEAR = 50.0, 4.5, nw.SteeringGear(dead_time=1.0, lag=1.5)
DOUBTS = {1.0: 2.0, 2.5: 1.0}
"""Factor of the standard deviations, and how much its flights count."""


def flights(ships: int, seed: int) -> list[tuple[float, Flights]]:
    model, scenes = with_gear(full_scale(), GEAR), tuple(SCENES.values())
    doubtful = {size: replace(model, covariance=model.covariance * size**2) for size in DOUBTS}
    return [(DOUBTS[size], Flights(own, HOLD, SPEED, scenes, ships, seed)) for size, own in doubtful.items()]


def main(ships: int = 250, rounds: int = 30) -> None:
    tuning = flights(ships, 5)

    def cost(point: np.ndarray) -> float:
        weights = weights_at(point)
        flown = [(share, flight.fly(weights)) for share, flight in tuning] if weights else [(1.0, None)]
        return sum(math.inf if one is None else share * cost_of(one) for share, one in flown)

    found = weights_at(searched(cost, np.append(np.zeros(len(TUNED)), USUAL.bank), rounds, lambda done: None))
    print(found)
    for _, flight in flights(10 * ships, 99):
        for weights in (found, USUAL):
            flown = flight.fly(weights)
            print(dict(zip(SCENES, (1000 * flown.lost.mean(axis=1)).round(), strict=True)))


if __name__ == "__main__":
    main()
