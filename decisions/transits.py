"""What transits of a canal can promise: twins whose truth is known, fitted as a ship's own log would be.

python decisions/transits.py [--write] [--twins 20]

The ship is the KCS as identified from measured tests, at 399.94 m in a canal 205 m wide (``suez.py``), at 8 knots for
40 minutes. Each twin is drawn from the covariance of its tests; those that a pilot who knows them does not bring
through in the gusts are not counted. What stands in the table is how often 95 % intervals hold the truth.
"""

import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from pages import markdown, publish

import narrows as nw
from narrows.logbook.learning_demo import MINUTES, SPEED, large_container_ship, transits_of
from narrows.logbook.sensor_grades import AIS, RTK, VDR, SensorGrade
from narrows.logbook.transit_twins import TransitTwin, drawn_truth
from narrows.terms.tables import table_named
from narrows.waterway import Bank, Centreline

TWINS = 20
MOST_DRAWN = 200
BANKS = ("b_bank", "c_bank")
STEERED_AIS = SensorGrade("ais with the rudder", AIS.words, {**AIS.signals, "rudder": VDR.signals["rudder"]})
GRADES = {"rtk": RTK, "vdr": VDR, "ais and the rudder": STEERED_AIS}
EVERY = 600.0
"""From one ship that passes to the next [s]."""


@dataclass(frozen=True)
class Kind:
    """A row: what a twin has that the fit does not know.

    Parameters
    ----------
    words : str
        For the table.
    transits : int
        In each fit.
    sensors : str
        By which grade they are recorded.
    truth : str
        What the ship is: ``drawn``, ``no c_bank``, ``y_B`` (another form of the bank).
    shifted : float [m]
        How far the banks are from where they are thought to be.
    deeper : float [1]
        Depth of the water over what it is thought to be.
    lighter : float [1]
        Draft over what it is thought to be.
    passing : bool
        Whether another ship passes every ten minutes.
    bends : bool
        Whether the canal has bends, which the fit knows.
    """

    words: str
    transits: int = 5
    sensors: str = "vdr"
    truth: str = "drawn"
    shifted: float = 0.0
    deeper: float = 1.0
    lighter: float = 1.0
    passing: bool = False
    bends: bool = False


KINDS = (
    *(Kind(f"{grade}, {count} transit{'s' * (count > 1)}", count, grade) for grade in GRADES for count in (1, 5, 20)),
    Kind("no bank in the moment", truth="no c_bank"),
    Kind("no bank in the moment, 20 transits", 20, truth="no c_bank"),
    Kind("bank of the form y_B", truth="distance"),
    Kind("banks 5 m from where they are charted", shifted=5.0),
    Kind("a ship passes every ten minutes", passing=True),
    Kind("draft a tenth less, and not said", lighter=0.9),
    Kind("water 5 % less deep than charted", deeper=0.95),
    Kind("round bends of 3 km", bends=True),
)


@cache
def ship() -> nw.Model:
    """As its tests tell."""
    return large_container_ship()


def twins(kind: Kind, count: int) -> Iterator[tuple[nw.Model, nw.ShipLog]]:
    """Ships that come through, with their logs."""
    left = count
    for seed in range(MOST_DRAWN):
        if not left:
            return
        held = {"c_bank": 0.0} if kind.truth == "no c_bank" else {}
        truth = drawn_truth(ship(), seed, **held)
        try:
            log = transits_of(_sailed(kind, truth), GRADES[kind.sensors], kind.transits, seed, _conditions(kind))
        except nw.InputError:
            continue
        left -= 1
        yield truth, _shifted(log, kind.shifted)


def _conditions(kind: Kind) -> TransitTwin:
    passes = np.arange(EVERY / 2, 60 * MINUTES, EVERY).tolist() if kind.passing else ()
    return TransitTwin(ship(), SPEED, 60 * MINUTES, passes=passes, waterway=winding() if kind.bends else None)


@cache
def winding() -> nw.Waterway:
    """A canal of the same section in bends to either side, with reaches between."""
    step = 20.0
    along = np.arange(0.0, 2.2 * SPEED * 60 * MINUTES, step)
    curvature = np.sin(along / 1200.0) ** 3 / 3000.0
    heading = np.cumsum(curvature) * step
    line = step * np.cumsum(np.stack([np.cos(heading), np.sin(heading)], axis=1), axis=0)
    canal, ends = ship().configuration.canal, np.array([0.0, along[-1]])
    half = np.full(2, canal.width / 2)
    sides = (Bank(side, ends, half) for side in ("starboard", "port"))
    return nw.Waterway(Centreline(line), *sides, (ends, np.full(2, canal.depth)), name="winding canal")


def _sailed(kind: Kind, truth: nw.Model) -> nw.Model:
    """The ship that sails, where it is not what the fit takes it for."""
    configuration = truth.configuration
    if kind.deeper != 1:
        return nw.at_depth(truth, kind.deeper * configuration.canal.depth).model
    if kind.lighter != 1:
        hull = replace(configuration.ship, draft=kind.lighter * configuration.ship.draft)
        return replace(truth, configuration=replace(configuration, ship=hull))
    if kind.truth == "distance":
        return _other_form(truth)
    return truth


def _other_form(truth: nw.Model) -> nw.Model:
    """Another form of the bank, as strong at 10 m off the middle."""
    table = table_named("steered+distance")
    own = {name: value for name, value in truth.coefficients.items() if name in table.names}
    at = nw.Motion.at(y=10.0, u=SPEED)
    bare = nw.Model(truth.configuration, table, {name: own.get(name, 1.0) for name in table.names})
    wanted, unit = truth.bank_forces(at), bare.bank_forces(at)
    scales = {
        term.name: bare[term.name] * wanted[force] / unit[force]
        for force, terms in table.forces.items() for term in terms if term.from_bank and unit[force]
    }  # fmt: skip
    return bare.with_coefficients(**scales)


def _shifted(log: nw.ShipLog, by: float) -> nw.ShipLog:
    records = [
        record.with_signals(y=replace(record["y"], values=record["y"].values + by)) if by else record for record in log
    ]
    return nw.ShipLog(tuple(records), log.waterway)


def row(kind: Kind, count: int) -> tuple[str, ...]:
    """How often intervals hold the truth, how wide they are, what is called unresolved."""
    found = [(truth, nw.learn(ship(), log, sensors=GRADES[kind.sensors])) for truth, log in twins(kind, count)]
    compared = kind.truth != "distance"
    cells = [f"{len(found)}"]
    for name in BANKS:
        off = np.array([(fit.model[name] - truth[name]) / fit.std[name] for truth, fit in found])
        cells += [_share(np.abs(off) < 1.96) if compared else "-", f"{off.mean():+.1f}" if compared else "-"]
    std = {name: float(np.median([fit.std[name] for _, fit in found])) for name in BANKS}
    unresolved = [fit.coefficients["c_bank"].holds_zero for _, fit in found]
    disagrees = [fit.disagrees for _, fit in found]
    return (kind.words, *cells, f"{std['b_bank']:.3f}", f"{std['c_bank']:.4f}", _share(unresolved), _share(disagrees))


def _share(cases: "np.ndarray | list[bool]") -> str:
    return f"{100 * np.mean(cases):.0f} %"


HEADS = (
    "twins", "fits", "b_bank covered", "off, in standard errors", "c_bank covered", "off", "standard error of b_bank",
    "of c_bank", "c_bank unresolved", "log and tests disagree",
)  # fmt: skip


def text(kinds: tuple[Kind, ...] = KINDS, count: int = TWINS) -> str:
    """One table."""
    rows = []
    for kind in kinds:
        rows.append(row(kind, count))
        print(rows[-1], file=sys.stderr, flush=True)
    return markdown(HEADS, rows)


if __name__ == "__main__":
    asked = int(sys.argv[sys.argv.index("--twins") + 1]) if "--twins" in sys.argv else TWINS
    publish(__file__, "learning.md", text(count=asked))
