"""What transits of a canal can promise: twins whose truth is known, fitted as a ship's own log would be.

python decisions/transits.py [--write] [--kept FOLDER] [--rows 0,3,5]

The ship is the KCS as identified from measured tests, at 399.94 m in a canal 205 m wide (``suez.py``), at 8 knots for
20 minutes. Each twin is drawn from the covariance of its tests; those that a pilot who knows them does not bring
through in the gusts are not counted. What stands in the table is how often 95 % intervals hold the truth. With
``--kept`` each twin's figures stand in a file of that folder as soon as they are known, and are not computed again.
"""

import json
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from other_hand import OtherTransit, misread
from pages import Rows, markdown, part, publish, records

import narrows as nw
from narrows.logbook.ship_log import AIS, RTK, VDR, SensorGrade
from narrows.logbook.transits import TransitTwin
from narrows.model.tables import table_named
from narrows.waterway import Bank, Centreline

sys.path.append(str(Path(__file__).parent.parent / "tests"))
from logs import PassedTransit
from twins import SPEED, drawn_truth, large_container_ship, transits_of

MOST_DRAWN, MINUTES, OFF = 2000, 20.0, 5.0
"""Ships that are drawn at most; of a transit; how far off the middle forms of the bank are compared [m]."""
BANKS = ("b_bank", "c_bank")
STEERED_AIS = SensorGrade("ais with the rudder", AIS.words, {**AIS.signals, "rudder": VDR.signals["rudder"]})
GRADES = {"rtk": RTK, "vdr": VDR, "ais and the rudder": STEERED_AIS}
EVERY = 600.0
"""From one ship that passes to the next [s]."""
PASSES = np.arange(EVERY / 2, 60 * MINUTES, EVERY)
USUAL = nw.TransitConditions()
OFF_MIDSHIP = nw.TransitConditions(gust_time=90.0, gust_correlation=0.8)
"""As a fit takes gusts to be at first, and others."""


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
    passing : {"", "marked", "not marked"}
        Whether another ship passes every ten minutes, and whether the log says so.
    bends : bool
        Whether the canal has bends, which the fit knows.
    gusts : TransitConditions
        Wind, gusts and aim; fits begin with gusts that stay 40 s, force and moment uncorrelated, which is the usual.
    other_hand : bool
        Whether pilot, gusts and instruments are those of ``other_hand.py``.
    twins : int
        How many.
    """

    words: str
    transits: int = 1
    sensors: str = "vdr"
    truth: str = "drawn"
    shifted: float = 0.0
    deeper: float = 1.0
    lighter: float = 1.0
    passing: str = ""
    bends: bool = False
    gusts: nw.TransitConditions = USUAL
    other_hand: bool = False
    twins: int = 30


KINDS = (
    Kind("rtk, 1 transit", sensors="rtk", twins=60),
    Kind("vdr, 1 transit", twins=100),
    Kind("ais and the rudder, 1 transit", sensors="ais and the rudder", twins=60),
    Kind("no bank in the moment", truth="no c_bank"),
    Kind("bank of the form y_B", truth="distance"),
    Kind("banks 5 m from where they are charted", shifted=5.0),
    Kind("water 5 % less deep than charted", deeper=0.95),
    Kind("draft a tenth less, unknown to the fit", lighter=0.9),
    Kind("a ship passes every ten minutes", passing="not marked"),
    Kind("a ship passes every ten minutes, marked in the log", passing="marked"),
    Kind("round bends of 3 km", bends=True),
    Kind("vdr, 5 transits", 5, twins=40),
    Kind("rtk, 5 transits", 5, sensors="rtk", twins=20),
    Kind("ais and the rudder, 5 transits", 5, sensors="ais and the rudder", twins=15),
    Kind("rtk, 20 transits", 20, sensors="rtk", twins=12),
    Kind("vdr, 20 transits", 20, twins=12),
    Kind("ais and the rudder, 20 transits", 20, sensors="ais and the rudder", twins=12),
    Kind("gusts that stay 90 s and act ahead of midship", gusts=OFF_MIDSHIP),
    Kind("another pilot, other gusts, poorer instruments", other_hand=True, twins=60),
    Kind("the same, 5 transits", 5, other_hand=True, twins=20),
    Kind("the same, bank of the form y_B", truth="distance", other_hand=True),
)
"""Without the rudder (ais alone) no fit is made, and the answer says why."""


@cache
def ship() -> nw.Model:
    """As its tests tell."""
    return large_container_ship()


def twin(kind: Kind, seed: int) -> tuple[nw.Model, nw.ShipLog] | None:
    """A ship with its log; None where it does not come through."""
    held = {"c_bank": 0.0} if kind.truth == "no c_bank" else {}
    truth = drawn_truth(ship(), seed, **held)
    try:
        sailing = replace(_conditions(kind), truth=_sailed(kind, truth))
        log = transits_of(sailing, GRADES[kind.sensors], kind.transits, seed)
    except nw.InputError:
        return None
    log = misread(log, seed) if kind.other_hand else _shifted(log, kind.shifted)
    return truth, _marked(log) if kind.passing == "marked" else log


def figures(kind: Kind, seed: int) -> dict[str, Any]:
    """What a twin taught, beside what it is; nothing where it does not come through."""
    if (made := twin(kind, seed)) is None:
        return {}
    truth, log = made
    try:
        fit = nw.learn(ship(), log, sensors=GRADES[kind.sensors])
    except nw.InputError:
        return {"refused": True}
    known = _alike(truth, _other_form(truth)) if kind.truth == "distance" else truth
    off = {name: (fit.model[name] - known[name]) / fit.std[name] for name in BANKS}
    told = {"off": off, "std": {name: fit.std[name] for name in BANKS}, "settled": fit.converged}
    disagrees = fit.disagrees or fit.has_unexplained_disturbance
    return told | {"unresolved": fit.coefficients["c_bank"].unresolved, "disagrees": disagrees}


def kept_figures(kind: Kind, count: int, folder: Path | None) -> Iterator[dict[str, Any]]:
    """Figures of so many twins, those that are kept first."""
    path = folder / f"{KINDS.index(kind):02d}.jsonl" if folder else None
    known = [json.loads(line) for line in path.read_text().splitlines()] if path and path.exists() else []
    left = count
    for seed in range(MOST_DRAWN):
        if not left:
            return
        told = known[seed] if seed < len(known) else figures(kind, seed)
        if path and seed >= len(known):
            with path.open("a", encoding="utf-8") as file:
                file.write(json.dumps(told) + "\n")
        if told:
            left -= 1
            yield told


def _conditions(kind: Kind) -> TransitTwin:
    told = (ship(), SPEED, 60 * MINUTES, kind.gusts, winding() if kind.bends else None)
    return OtherTransit(*told) if kind.other_hand else PassedTransit(*told, tuple(PASSES) if kind.passing else ())


def _marked(log: nw.ShipLog) -> nw.ShipLog:
    """What the bridge writes down: when the bow of another ship is less than a length from ours."""
    t = np.arange(0.0, 60 * MINUTES, 10.0)
    near = np.abs(t[:, None] - PASSES) < ship().configuration.ship.length / SPEED
    meeting = nw.Signal(t, near.any(axis=1).astype(float))
    return nw.ShipLog(tuple(record.with_signals(meeting=meeting) for record in log), log.waterway)


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


def _alike(model: nw.Model, other: nw.Model) -> nw.Model:
    """The coefficients with which its own form of the bank is as strong as another where transits sail."""
    at = nw.Motion.at(y=OFF, u=SPEED)
    wanted, own = other.bank_forces(at), model.bank_forces(at)
    return model.with_coefficients(b_bank=model["b_bank"] * wanted["Y"] / own["Y"],
                                   c_bank=model["c_bank"] * wanted["N"] / own["N"])  # fmt: skip


def _shifted(log: nw.ShipLog, by: float) -> nw.ShipLog:
    records = [
        record.with_signals(y=replace(record["y"], values=record["y"].values + by)) if by else record for record in log
    ]
    return nw.ShipLog(tuple(records), log.waterway)


def row(kind: Kind, count: int | None = None, folder: Path | None = None) -> tuple[str, ...]:
    """How often intervals hold the truth, how wide they are, and how often an answer says what it lacks."""
    every = list(kept_figures(kind, count or kind.twins, folder))
    found = [told for told in every if "off" in told]
    cells, ahead = [kind.words, f"{len(every)}"], predicted(kind)
    for name in BANKS:
        off = np.array([told["off"][name] for told in found])
        cells += [_share(np.abs(off) < WIDE), f"{off.mean():+.1f}"]
        cells += [f"{np.median([told['std'][name] for told in found]):.4f}", ahead[name]]
    cells += [_share([told[word] for told in found]) for word in ("unresolved", "disagrees")]
    return (*cells, _restless(found))


def _restless(found: list[dict[str, Any]]) -> str:
    """How often a search did not come to rest, and where there are enough of them, how often c_bank is covered then."""
    left = [told for told in found if not told["settled"]]
    often = f"{100 * len(left) / len(found):.0f} %"
    if len(left) < ENOUGH:
        return often
    return f"{often}, c_bank covered in {_share([abs(told['off']['c_bank']) < WIDE for told in left])}"


def predicted(kind: Kind) -> dict[str, str]:
    """Standard errors by ``predict_information`` of transits like these, where all is as it is taken."""
    if kind != Kind(kind.words, kind.transits, kind.sensors, twins=kind.twins):
        return dict.fromkeys(BANKS, "-")
    told = {"u": SPEED, "duration": 60 * MINUTES}
    routine = nw.predict_information(ship(), None, GRADES[kind.sensors], (kind.transits,), **told)
    return {name: f"{routine.std[name][0]:.4f}" for name in BANKS}


WIDE, ENOUGH = 1.96, 20
"""Standard errors of an interval; fits of which a share is told."""


def _share(cases: "np.ndarray | list[bool]") -> str:
    return f"{100 * np.mean(cases):.0f} %"


OF_BANK = ("covered", "off, in standard errors", "standard error", "predicted")
HEADS = (
    "sensors and transits", "twins", *(f"{name} {word}" for name in BANKS for word in OF_BANK),
    "c_bank unresolved", "reports a contradiction", "did not converge",
)  # fmt: skip
SHOWN = (0, 1, 2, 11, 15, 3, 4, 5, 6, 7, 8, 9, 18)
"""Kinds of the page."""


def text(kinds: tuple[Kind, ...] = KINDS, folder: Path | None = None) -> str:
    """One table."""
    rows = []
    for kind in kinds:
        rows.append(row(kind, folder=folder))
        print(rows[-1], file=sys.stderr, flush=True)
    return markdown(HEADS, rows)


def shown(rows: Rows) -> str:
    """Some kinds, without forecasts and mean errors; two digits of a standard error."""
    found = {row[HEADS[0]]: row for row in records(rows, HEADS[0])}
    known = (f"{name} {word}" for name in BANKS for word in ("covered", "standard error"))
    rows = [found[KINDS[k].words] for k in SHOWN]
    rounded = [
        row | {head: f"{float(row[head]):#.2g}" for head in row if head.endswith("standard error")} for row in rows
    ]
    return part(rounded, HEADS[0], *known, "reports a contradiction")


def _asked(option: str) -> str | None:
    return sys.argv[sys.argv.index(option) + 1] if option in sys.argv else None


if __name__ == "__main__":
    chosen = tuple(KINDS[int(number)] for number in (_asked("--rows") or "").split(",") if number) or KINDS
    publish(__file__, "learning.md", text(chosen, Path(kept) if (kept := _asked("--kept")) else None), shown)
