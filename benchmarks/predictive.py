"""A predictive helm flown on five scenes with truths that it does not know, and the time of its orders.

python benchmarks/predictive.py [TRUTHS] [--small]

The ship is the KCS of 230 m in a canal of 300 m by 16.2 m, identified from the measured tests. Each truth has
coefficients drawn from the covariance of the fit; what the helm sees is noisy. The table has, by scene: how many of the
truths ran aground under the helm, and how many of these under the same helm, too, that is told their coefficients and
may choose an offset nearer to the middle (a scene may ask for what no rudder can do); how many were not within half a
beam of the line through the last minute; the largest offset, median and 95 % of those afloat; the median of the travel
of the rudder; process time of an order.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from time import process_time
from typing import Any

import numpy as np
from common import installed, machine, sizes
from rich.console import Console
from rich.table import Table

import narrows as nw
from narrows.captive.measured import measured_files
from narrows.control import PredictiveHelm
from narrows.simulation.controllers import VoyageState
from narrows.simulation.samples import sampled
from narrows.terms.tables import table_named
from narrows.waterway import Bank, Centreline, Waterway

TURNED = "type in ('PMMY2', 'PMMPSI2', 'STATX0', 'MULTI0') and u_mps > 0.2 and abs(psi_deg) < 20"
SPEED, DURATION, STEP, LAST = 4.5, 600.0, 1.0, 60
WIDTH, DEPTH, RADIUS = 300.0, 16.2, 2500.0
NOISE = {"y": 0.3, "psi": np.radians(0.05), "v": 0.01, "r": np.radians(0.002)}
"""Standard deviations of what is seen [m, rad, m/s, rad/s]."""
SEED = 7
AT_A_TIME = 20
"""Orders between two looks at the clock, which itself takes time."""


def ship() -> nw.Model:
    """Identify the KCS at half its draught under the keel, and bring it to full size."""
    tests = nw.read_captive(*measured_files("kcs"), TURNED).by_condition()["C0101A02"]
    return nw.scale_model(
        nw.identify(tests, table_named("speed+helm")).model, 230.0, 1025.0, width=WIDTH, depth=DEPTH
    ).model


def moment_of_rudder(model: nw.Model, degrees: float) -> float:
    """The yaw moment of a rudder angle at the speed of the scenes [N m]."""
    motion = nw.Motion.at(0.0, u=SPEED)
    turned, straight = (model.forces(motion, rudder=angle)["N"] for angle in (np.radians(degrees), 0.0))
    return float(turned - straight)


def bend() -> Waterway:
    """450 m straight, 990 m along an arc of ``RADIUS`` to starboard, and straight on."""
    s = np.arange(0.0, 3301.0, 10.0)
    curvature = np.where((s >= 450) & (s < 1440), 1 / RADIUS, 0.0)
    heading = np.concatenate([[0.0], np.cumsum((curvature[1:] + curvature[:-1]) / 2 * 10.0)])
    middle = (heading[1:] + heading[:-1]) / 2
    points = np.cumsum(10.0 * np.stack([np.sin(middle), np.cos(middle)], axis=1), axis=0)
    line = Centreline(np.concatenate([[[0.0, 0.0]], points]))
    ends, half = np.array([0.0, line.length]), np.full(2, WIDTH / 2)
    return Waterway(
        line, Bank("starboard", ends, half), Bank("port", ends, half), (ends, np.full(2, DEPTH)), name="bend"
    )


def scenes(model: nw.Model) -> dict[str, dict[str, Any]]:
    """What each scene asks: the offset to hold, and what ``simulate`` is told."""
    push, weaker = moment_of_rudder(model, 6.0), moment_of_rudder(model, 5.0)
    gust, storm = (nw.wind_force(wind, area=6000.0) for wind in (15.0, 18.0))
    both_ways = [(100.0, gust), (160.0, 0.0), (300.0, -gust), (360.0, 0.0)]
    return {
        "10 m offset": {"hold": 40.0, "y": 50.0},
        "sudden bank": {"hold": 50.0, "N": [(100.0, push), (180.0, 0.0), (300.0, -push), (380.0, 0.0)]},
        "gust": {"hold": 40.0, "Y": both_ways, "N": [(time, 20.0 * force) for time, force in both_ways]},
        "bend": {"hold": 0.0, "waterway": bend()},
        "hard": {
            "hold": 65.0, "Y": [(100.0, storm), (160.0, 0.0)],
            "N": [(100.0, 20.0 * storm), (160.0, 0.0), (250.0, weaker), (310.0, 0.0)],
        },
    }  # fmt: skip


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


def flown(truth: nw.Model, helm: Any, number: int, duration: float, told: Mapping[str, Any]) -> nw.Voyage:
    """One voyage of one truth from its line, the heading off by a degree (standard deviation)."""
    psi = np.radians(1.0) * np.random.default_rng(number).standard_normal()
    start = {"y": told["hold"], "psi": psi, **{name: value for name, value in told.items() if name != "hold"}}
    return nw.simulate(truth, u=SPEED, duration=duration, dt=STEP, controller=Watched(helm, 1000 + number), **start)


def knowing(truth: nw.Model, told: Mapping[str, Any]) -> PredictiveHelm | None:
    """The helm that knows the truth, at the offset or, where no rudder holds that, at the nearest that one does."""
    for y in np.arange(told["hold"], -1.0, -5.0):
        helm = PredictiveHelm(truth, float(y), SPEED, told.get("waterway"))
        try:
            helm.begin()
        except nw.InputError:
            continue
        return helm
    return None


def row(model: nw.Model, truths: list[nw.Model], told: Mapping[str, Any], duration: float) -> tuple[str, ...]:
    """One scene as a row of the table."""
    helm, half_beam = (
        PredictiveHelm(model, told["hold"], SPEED, told.get("waterway")),
        model.configuration.ship.beam / 2,
    )
    voyages = [flown(truth, helm, number, duration, told) for number, truth in enumerate(truths)]
    afloat = [voyage for voyage in voyages if voyage.outcome.kind == "afloat"]
    known = 0
    for number, truth in enumerate(truths):
        if voyages[number].outcome.kind != "afloat":
            one = knowing(truth, told)
            known += one is None or flown(truth, one, number, duration, told).outcome.kind != "afloat"
    if not afloat:
        return (str(len(voyages)), str(known), str(len(voyages)), *["-"] * 4)
    off = np.array([np.abs(voyage.y - told["hold"]).max() for voyage in afloat])
    late = np.array([np.abs(voyage.y[-LAST:] - told["hold"]).max() for voyage in afloat])
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
    for name, told in list(scenes(model).items())[:most]:
        cells = row(model, truths, told, duration)
        first = first or cells[-1]
        ratio = f"{float(cells[-1]) / float(first):.2f}" if "-" not in (first, cells[-1]) else "-"
        made.add_row(name, *cells, ratio)
    return made


def main(count: int, small: bool) -> None:
    """Print the tables: as the tests know the ship, and as tests that know twice as much would."""
    if not installed("daqp"):
        return
    for spread in (1.0,) if small else (1.0, 0.5):
        shown = table(ship(), count, spread, 60.0, 1) if small else table(ship(), count, spread, DURATION)
        Console(width=110).print(shown)


if __name__ == "__main__":
    main(*sizes(__doc__, 200, 1))
