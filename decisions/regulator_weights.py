"""Default weights of the regulator: tuned by trials of the KCS at full size, with a gear, at two covariances.

The KCS of 230 m sails with the covariance of its tests, which counts twice, and with 2.5 times its standard deviations,
about those of a ship without tests. The gear has 1 s of dead time and 1.5 s of lag. The printed weights are rounded by
hand into ``RegulatorWeights``.

python decisions/regulator_weights.py
"""

import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

import narrows as nw
from narrows.control.design import SCENES, TUNED, DesignTrials, cost_of, searched, weights_at, with_gear
from narrows.control.regulator import DEFAULT_WEIGHTS

sys.path.append(str(Path(__file__).parent.parent / "benchmarks"))
from envelope import full_scale

HOLD, SPEED, GEAR = 50.0, 4.5, nw.SteeringGear(dead_time=1.0, lag=1.5)
DOUBTS = {1.0: 2.0, 2.5: 1.0}
"""Factor of the standard deviations, and how much its trials count."""


def trials(ships: int, seed: int) -> list[tuple[float, DesignTrials]]:
    model, scenes = with_gear(full_scale(), GEAR), tuple(SCENES.values())
    doubtful = {size: replace(model, covariance=model.covariance * size**2) for size in DOUBTS}
    return [(DOUBTS[size], DesignTrials(own, HOLD, SPEED, scenes, ships, seed)) for size, own in doubtful.items()]


def main(ships: int = 250, rounds: int = 30) -> None:
    tuning = trials(ships, 5)

    def cost(point: np.ndarray) -> float:
        weights = weights_at(point)
        results = [(share, trial.run(weights)) for share, trial in tuning] if weights else [(1.0, None)]
        return sum(math.inf if one is None else share * cost_of(one) for share, one in results)

    found = weights_at(searched(cost, np.append(np.zeros(len(TUNED)), DEFAULT_WEIGHTS.bank), rounds))
    print(found)
    for _, trial in trials(10 * ships, 99):
        for weights in (found, DEFAULT_WEIGHTS):
            result = trial.run(weights)
            print(dict(zip(SCENES, (1000 * result.lost.mean(axis=1)).round(), strict=True)))


if __name__ == "__main__":
    main()
