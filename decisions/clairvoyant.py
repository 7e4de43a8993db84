"""Best rudder of ships that a helm lost: a lower bound of the share that any helm loses, known to nobody at sea.

A ship is known exactly, without noise, with all pushes to come. Its regulator steers it along a line that a search
shifts, with rudder added: 24 numbers for ten minutes, by the cross-entropy method (Rubinstein 1999), for all lost ships
at once. Any rudder that saves a ship proves that it can be saved; a ship that the search loses may still be savable.
"""

import sys
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np

import narrows as nw
from narrows.control.regulator import HeldLine

sys.path.append(str(Path(__file__).parent.parent / "benchmarks"))
from scenes.five_scenes import DURATION, SPEED, Scene
from scenes.fleet import Fleet
from scenes.helms import Laws, knowing

KNOTS, POPULATION, ELITES, ROUNDS, LATE = 12, 24, 6, 30, 60
SIZES = np.repeat([0.5, 0.1], KNOTS)
"""First standard deviations: shift of the line [beams], then rudder [rad]."""


def chosen_rows(value: Any, rows: np.ndarray) -> Any:
    """Numbers of some ships, where a value has one for each ship."""
    if isinstance(value, tuple):
        return tuple(chosen_rows(one, rows) for one in value)
    return value[rows] if isinstance(value, np.ndarray) else value


def unsaved(fleet: Fleet, scene: Scene, seed: int = 5) -> int:
    """Number of the fleet's lost ships that no rudder of the search saves."""
    lost, random = np.flatnonzero(fleet.lost), np.random.default_rng(seed)
    law, mean = knowing(fleet, scene), np.zeros((len(lost), 2 * KNOTS))
    size = np.tile(SIZES, (len(lost), 1))
    for _ in range(ROUNDS):
        if not len(lost):
            break
        tries = mean[:, None] + size[:, None] * random.standard_normal((len(lost), POPULATION, 2 * KNOTS))
        tries[:, 0] = mean
        rows = np.repeat(lost, POPULATION)
        lines = [HeldLine(*(chosen_rows(getattr(own, part.name), rows) for part in fields(own))) for own in law.lines]
        cost = sailed(fleet, scene, replace(law, lines=tuple(lines)), rows, tries.reshape(len(rows), -1))
        cost = cost.reshape(len(lost), POPULATION)
        best = np.take_along_axis(tries, np.argsort(cost, axis=1)[:, :ELITES, None], axis=1)
        mean, size = best.mean(axis=1), best.std(axis=1) + 0.02 * SIZES
        left = cost.min(axis=1) > 1.0
        lost, mean, size = lost[left], mean[left], size[left]
    return len(lost)


def sailed(fleet: Fleet, scene: Scene, law: Any, rows: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    """Late offset of each ship under its rudder [half beams]; more, the sooner it meets a bank."""
    model, own = fleet.model, Fleet(fleet.model, len(rows), waterway=fleet.waterway)
    own.__dict__["truths"] = {name: column[rows] for name, column in fleet.truths.items()}
    course = {
        name: float(value) for name, value in nw.control.linearize(model, scene.lines[0][1], SPEED).course.items()
    }
    own.begin(scene.lines[0][1], fleet.psi[rows], course["v"], course["rudder"])
    steers, beam, last = Laws(law, own), model.configuration.ship.beam, np.zeros(len(rows))
    late, place = np.zeros(len(rows)), np.linspace(0.0, KNOTS - 1, DURATION)
    for t in range(DURATION):
        knot = min(int(place[t]), KNOTS - 2)
        share = place[t] - knot
        shift, more = ((1 - share) * part[:, knot] + share * part[:, knot + 1] for part in np.split(numbers, 2, axis=1))
        seen = {**own.state, "psi": np.arctan2(own.state["sin_psi"], own.state["cos_psi"])}
        order = steers({**seen, "y": seen["y"] - beam * shift}, own.alive)
        own.step(order + more, scene.push(t))
        last += own.alive
        if t >= DURATION - LATE:
            late = np.maximum(late, np.abs(own.state["y"] - scene.wanted(t)) / (beam / 2))
    return np.where(own.alive, late, 100.0 + DURATION - last)
