"""A predictive helm flown on five scenes with truths that it does not know, and the time of its orders.

python benchmarks/predictive.py [TRUTHS] [--small]

The ship is the KCS of 230 m in a canal of 300 m by 16.2 m, identified from the measured tests. Each truth has
coefficients drawn from the covariance of the fit; what the helm sees is noisy. The table has, by scene: how many of the
truths ran aground under the helm, and how many of these under the same helm, too, that is told their coefficients and
may choose an offset nearer to the middle (a scene may ask for what no rudder can do); how many were not within half a
beam of the line through the last minute; the largest offset, median and 95 % of those afloat; the median of the travel
of the rudder; process time of an order.
"""

from dataclasses import dataclass, replace
from time import process_time
from typing import Any

import numpy as np
from common import installed, machine, sizes
from envelope import full_scale
from rich.console import Console
from rich.table import Table
from scenes import five_scenes
from scenes.five_scenes import DURATION, SPEED, Scene
from scenes.fleet import NOISE

import narrows as nw
from narrows.control import PredictiveHelm
from narrows.simulation.controllers import VoyageState
from narrows.simulation.grid import sampled

STEP, LAST, START = 1.0, 60, 200.0
"""Of a voyage [s], the seconds at its end through which a ship is to be back, and where it begins [m]."""
SEED = 7
AT_A_TIME = 20
"""Orders between two looks at the clock, which itself takes time."""


def scenes(model: nw.Model) -> dict[str, Scene]:
    """The five scenes; the one of a line that moves is a start 10 m off it, pushes are those of 6 degrees of rudder."""
    motion, angle = nw.Motion.at(0.0, u=SPEED), np.radians(6.0)
    turned, straight = (model.forces(motion, rudder=rudder)["N"] for rudder in (angle, 0.0))
    pushed = five_scenes.scenes(model, float(turned - straight) / angle)
    return {**pushed, "offset": Scene(((0.0, 40.0),), begins=50.0)}


@dataclass
class Watched:
    """A helm that sees with noise."""

    helm: Any
    seed: int

    def begin(self) -> Any:
        """Return the orders of one voyage."""
        order, random = self.helm.begin(), np.random.default_rng(self.seed)

        def watched(t: float, state: VoyageState) -> float:
            wrong = dict(zip(NOISE, random.standard_normal(4) * list(NOISE.values()), strict=True))
            seen = state._replace(**{name: getattr(state, name) + off for name, off in wrong.items()})
            return float(order(t, seen))

        return watched


def flown(truth: nw.Model, helm: Any, number: int, duration: float, scene: Scene) -> nw.Voyage:
    """One voyage of one truth from its line, the heading off by a degree (standard deviation)."""
    psi = np.radians(1.0) * np.random.default_rng(number).standard_normal()
    start = {"x": START, "y": scene.start, "psi": psi, "u": SPEED, "waterway": scene.waterway, **scene.forces()}
    return nw.simulate(truth, duration=duration, dt=STEP, controller=Watched(helm, 1000 + number), **start)


def knowing(truth: nw.Model, scene: Scene) -> PredictiveHelm | None:
    """The helm that knows the truth, at the offset or, where no rudder holds that, at the nearest that one does."""
    for y in np.arange(scene.wanted(0.0), -1.0, -5.0):
        helm = PredictiveHelm(truth, float(y), SPEED, scene.waterway)
        try:
            helm.begin()
        except nw.InputError:
            continue
        return helm
    return None


def row(model: nw.Model, truths: list[nw.Model], scene: Scene, duration: float) -> tuple[str, ...]:
    """One scene as a row of the table."""
    line, half_beam = scene.wanted(0.0), model.configuration.ship.beam / 2
    helm = PredictiveHelm(model, line, SPEED, scene.waterway)
    voyages = [flown(truth, helm, number, duration, scene) for number, truth in enumerate(truths)]
    afloat = [voyage for voyage in voyages if voyage.outcome.kind == "afloat"]
    known = 0
    for number, truth in enumerate(truths):
        if voyages[number].outcome.kind != "afloat":
            one = knowing(truth, scene)
            known += one is None or flown(truth, one, number, duration, scene).outcome.kind != "afloat"
    if not afloat:
        return (str(len(voyages)), str(known), str(len(voyages)), *["-"] * 4)
    off = np.array([np.abs(voyage.y - line).max() for voyage in afloat])
    late = np.array([np.abs(voyage.y[-LAST:] - line).max() for voyage in afloat])
    travel = np.degrees([np.abs(np.diff(voyage.rudder)).sum() for voyage in afloat])
    lost = len(voyages) - len(afloat) + int((late > half_beam).sum())
    numbers = (f"{np.median(off):.1f}", f"{np.quantile(off, 0.95):.1f}", f"{np.median(travel):.0f}")
    return (str(len(voyages) - len(afloat)), str(known), str(lost), *numbers, f"{milliseconds(helm, voyages[0]):.2f}")


def milliseconds(helm: PredictiveHelm, voyage: nw.Voyage) -> float:
    """Median process time of an order on the states of a voyage [ms]."""
    order, times = helm.begin(), []
    columns = (voyage.x, voyage.y, voyage.psi, voyage.u, voyage.v, voyage.r, voyage.rudder)
    states = [VoyageState(*map(float, numbers)) for numbers in zip(*columns, strict=True)]
    for first in range(0, len(states) - AT_A_TIME, AT_A_TIME):
        begun = process_time()
        for number in range(first, first + AT_A_TIME):
            order(float(voyage.t[number]), states[number])
        times.append((process_time() - begun) / AT_A_TIME)
    return 1e3 * float(np.median(times[1:]))


def table(model: nw.Model, count: int, spread: float, duration: float, most: int | None = None) -> Table:
    """Every scene, or the first ones; the coefficients' standard deviations times ``spread``."""
    model = replace(model, covariance=model.covariance * spread**2)
    drawn = {name: column.values for name, column in sampled(model, count, SEED).items()}
    truths = [
        replace(model, coefficients={name: float(column[number]) for name, column in drawn.items()})
        for number in range(count)
    ]
    title = f"a predictive helm, {count} truths a scene, standard deviations x {spread:g}"
    made = Table(title=title, caption=machine())
    for header in ("scene", "aground", "knowing", "not back", "off [m]", "95 %", "travel [deg]", "order [ms]", "ratio"):
        made.add_column(header, justify="left" if header == "scene" else "right")
    first = ""
    for name, scene in list(scenes(model).items())[:most]:
        cells = row(model, truths, scene, duration)
        first = first or cells[-1]
        ratio = f"{float(cells[-1]) / float(first):.2f}" if "-" not in (first, cells[-1]) else "-"
        made.add_row(name, *cells, ratio)
    return made


def main(count: int, small: bool) -> None:
    """Print the tables: as the tests know the ship, and as tests that know twice as much would."""
    if not installed("daqp"):
        return
    for spread in (1.0,) if small else (1.0, 0.5):
        shown = table(full_scale(), count, spread, *((60.0, 1) if small else (DURATION,)))
        Console(width=110).print(shown)


if __name__ == "__main__":
    main(*sizes(__doc__, 200, 1))
