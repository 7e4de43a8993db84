"""Helms on five scenes, the truth's coefficients drawn from the covariance and the measurements noisy.

A 230 m container ship in a canal 300 m wide: a line 10 m further off, a bank that recedes for 80 s (the moment of 6
degrees of rudder), gusts of 15 m/s, a bend of 2500 m, and all at once 65 m off the middle in 18 m/s of wind. Two helms
know the mean coefficients, and not which truth they steer; one that knows each truth shows what is left to be won.

python benchmarks/helm_scenes.py [TRUTHS] [--small]
"""

import time
from collections.abc import Collection
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from common import machine, sizes
from envelope import full_scale
from rich.console import Console
from rich.table import Table
from scenes.five_scenes import DURATION, SPEED, Scene, scenes
from scenes.fleet import DT, Fleet
from scenes.helms import HELMS, Laws, Objects, track_pilot

import narrows as nw

LATE = 60
"""Seconds at the end, through which a ship is to be back."""
SPREADS = (1.0, 0.5)
"""Of the coefficients' standard deviations: as the tests know the ship, and as tests that know twice as much would."""


def fly(fleet: Fleet, scene: Scene, helm: Any, seed: int = 3) -> dict[str, float]:
    """Fly one scene: how far off, how much rudder, how many lost."""
    rng, linear = np.random.default_rng(seed), nw.control.linearize(fleet.model, scene.lines[0][1], SPEED)
    course = {name: float(value) for name, value in linear.course.items()}
    psi = course["psi"] + np.radians(1) * rng.standard_normal(fleet.count)
    fleet.begin(scene.lines[0][1], psi, course["v"], course["rudder"])
    several = helm if isinstance(helm, list) else [(0.0, helm)]
    kind = Laws if hasattr(several[0][1], "orders") else Objects
    helms = [(start, kind(own, fleet)) for start, own in several]
    far, late, spent = np.zeros(fleet.count), np.zeros(fleet.count), 0.0
    for t in range(DURATION):
        told, now = fleet.told(rng), [own for start, own in helms if start <= t][-1]
        begun = time.process_time()
        order = now(told, fleet.alive)
        spent += time.process_time() - begun
        fleet.step(order, scene.push(t))
        off = np.abs(fleet.state["y"] - scene.wanted(t))
        far = np.where(fleet.alive, np.maximum(far, off), far)
        late = np.maximum(late, off) if t >= DURATION - LATE else late
    fleet.lost = lost = ~(fleet.alive & (late < fleet.model.configuration.ship.beam / 2))
    afloat = fleet.alive if fleet.alive.any() else ~fleet.alive
    return {
        "deviation": float(np.median(far[afloat])), "deviation_95": float(np.quantile(far[afloat], 0.95)),
        "travel": float(np.degrees(np.median(fleet.travel[afloat]))), "aground": float((~fleet.alive).mean()),
        "lost": float(lost.mean()), "order_us": 1e6 * spent / DURATION / fleet.count,
    }  # fmt: skip


def flown(
    model: nw.Model, truths: int, chosen: Collection[str] = (), spread: float = 1.0
) -> dict[tuple[str, str], dict[str, float]]:
    """Every scene, or those chosen, under every helm; the coefficients' standard deviations times ``spread``."""
    drawn, found = replace(model, covariance=model.covariance * spread**2), {}
    for name, scene in scenes(model).items():
        for kind, helm in HELMS.items() if name in chosen or not chosen else ():
            fleet = Fleet(drawn, truths, waterway=scene.waterway)
            found[name, kind] = fly(fleet, scene, helm(fleet, scene))
    return found


def recovered(model: nw.Model, y: float, helm: Any, across: int) -> float:
    """The share of starts off the line, of those that have room, from which the mean ship is back after 500 s."""
    off, turned = (
        part.ravel() for part in np.meshgrid(np.linspace(-60, 60, across), np.radians(np.linspace(-12, 12, across)))
    )
    course = {name: float(value) for name, value in nw.control.linearize(model, y, SPEED).course.items()}
    psi, ship = course["psi"] + turned, model.configuration.ship
    reach = ship.length / 2 * np.abs(np.sin(psi)) + ship.beam / 2 * np.cos(psi)
    fits = model.configuration.canal.width / 2 - np.abs(y + off) - reach > 1.0
    start = {"y": y + off[fits], "psi": psi[fits]}
    columns = {name: xr.DataArray(column, dims="start") for name, column in start.items()}
    told = {"u": SPEED, "v": course["v"], "rudder": course["rudder"], "duration": 500.0, "dt": DT}
    ended = nw.ensemble(model, controller=helm, **columns, **told)
    return float(((ended["outcome"] == 0) & (np.abs(ended["y_end"] - y) < ship.beam / 2)).mean())


def table(model: nw.Model, truths: int, spread: float, chosen: Collection[str] = ()) -> Table:
    """Every scene, or those chosen, under every helm."""
    headers = (
        "scene", "helm", "median deviation m", "95 % m", "rudder travel deg", "aground of 1000", "lost of 1000",
        "ratio", "us an order",
    )  # fmt: skip
    made = Table(title=f"five scenes, {truths} truths each, standard deviations x {spread:g}", caption=machine())
    for header in headers:
        made.add_column(header, justify="left" if header in headers[:2] else "right")
    rows = flown(model, truths, chosen, spread)
    for (scene, kind), row in rows.items():
        before = rows[scene, "track"]["lost"]  # the helm that the others are compared with
        numbers = [row[name] for name in ("deviation", "deviation_95", "travel")]
        numbers += [1000 * row["aground"], 1000 * row["lost"], row["lost"] / before if before else float("nan")]
        made.add_row(scene, kind, *(f"{number:.3g}" for number in (*numbers, row["order_us"])))
    return made


def main(truths: int, small: bool) -> None:
    """Fly and print."""
    model, console, across = full_scale(), Console(width=160), 5 if small else 21
    for spread in SPREADS[: 1 if small else None]:
        console.print(table(model, truths, spread, ("offset", "bend") if small else ()))
    starts = Table(title=f"share of {across} x {across} starts recovered, 60 m and 12 degrees to either side")
    for header in ("y m", "track", "regulator"):
        starts.add_column(header, justify="right")
    for y in (50.0, 65.0):
        helms = (track_pilot(model, y, SPEED), nw.control.regulator(model, y, SPEED))
        starts.add_row(f"{y:g}", *(f"{recovered(model, y, helm, across):.3f}" for helm in helms))
    console.print(starts)


if __name__ == "__main__":
    main(*sizes(__doc__, usual=1000, small=3))
