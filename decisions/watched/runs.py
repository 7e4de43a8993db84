"""Transits with what every predictor foretells of them, some at a time, kept so that a run can go on."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from narrows.estimation import Estimator, Gnss, Gyro, Log, RateOfTurn, RudderIndicator
from watched.filters import FiltersAbreast, readings_of
from watched.forecasts import COLUMNS, ForecastsAbreast
from watched.truths import DURATION, Physics, Transits, modelled

SENSORS = (Gnss(), Gyro(), RateOfTurn(), Log(), RudderIndicator())
ABREAST, MEMBERS = 100, 128
FROM, EVERY, AFTERWARDS = 60, 2, 120
"""From when on it is foretold, between two forecasts, and how long it is seen what becomes of a ship at the end [s]."""
Run = dict[str, np.ndarray]


def watched(physics: Physics, seed: int, count: int = ABREAST, members: int = MEMBERS) -> Run:
    """Transits of ships, and what is foretold of them, (times, ships)."""
    estimator, random = Estimator(modelled(), SENSORS), np.random.default_rng(seed + 1)
    ships, filters = Transits(physics, count, seed), FiltersAbreast(estimator, count)
    forecasts, before, told = ForecastsAbreast(estimator, count, members), ships.indicated, []
    for t in range(DURATION):
        readings, now = readings_of(estimator, {**ships.state, "psi": ships.psi}, random), ships.indicated
        if t:
            filters.update(readings, before, now)
        else:
            filters.begin(readings, np.arange(count))
        if t >= FROM and (t - FROM) % EVERY == 0:
            told.append(forecasts.columns(filters.normal(), now, ships.alive))
        before = now
        ships.step(t)
    for t in range(DURATION, DURATION + AFTERWARDS):
        ships.step(t)
    columns = {name: np.array([row[name] for row in told], np.float32) for name in COLUMNS}
    return {**columns, "struck": ships.contact, "least": ships.least, "upset": ships.upset, "when": ships.when}


def kept_runs(physics: Physics, number: int, transits: range, folder: Path | None) -> Iterator[Run]:
    """Transits of a kind, by their numbers; those that are kept in the folder are not sailed again."""
    for part in range(transits.start // ABREAST, transits.stop // ABREAST):
        path = folder / f"{number}-{part:03d}.npz" if folder else None
        if path and path.exists():
            with np.load(path) as kept:
                yield dict(kept)
            continue
        run = watched(physics, 1000 * number + part)
        if path:
            path.parent.mkdir(parents=True, exist_ok=True)
            unfinished = path.with_suffix(".part.npz")
            np.savez_compressed(unfinished, **run)
            unfinished.rename(path)
        yield run
