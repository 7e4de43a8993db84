"""Transits with what every predictor forecasts of them, kept so that a run can go on; people who act on an alert."""

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from narrows.estimation import Estimator, Gnss, Gyro, Log, RateOfTurn, RudderIndicator
from narrows.warning.forecasting.helmsman import escape_numbers
from watched.filters import FiltersAbreast, SensorErrors
from watched.forecasts import COLUMNS, ForecastsAbreast
from watched.truths import DURATION, LENGTH, Hands, Physics, Ships, departing, modelled, waterway

SENSORS = (Gnss(), Gyro(math.radians(0.2)), RateOfTurn(math.radians(0.03)), Log(), RudderIndicator())
ABREAST, MEMBERS = 128, 96
FROM, EVERY, BEFORE, ESCAPED = 120, 2, 300, 180
"""From when on it is forecast, between two forecasts; what is looked at before a contact and after an alert [s]."""
AROUND = 120, 480
"""What is forecast before and after a lapse begins [s]."""
STATE = ("x", "y", "cos_psi", "sin_psi", "u", "v", "r", "rudder", "order", "t")
Run = dict[str, np.ndarray]


def watched(physics: Physics, seed: int) -> Run:
    """Transits of ships: what is forecast about their lapses, and of the others all the time."""
    estimator = Estimator(modelled(), SENSORS, waterway=waterway())
    ships = departing(physics, ABREAST, seed).fresh(seed + 1)
    count = ships.count
    filters, hands = FiltersAbreast(estimator, count), Hands(ships, physics.abrupt)
    sensors = SensorErrors(filters, seed + 1)
    forecasts, before, told = ForecastsAbreast(estimator, count, MEMBERS), ships.indicated, []
    seen = np.zeros((DURATION, 6, count), np.float32)
    states = np.zeros((DURATION, len(STATE), count), np.float32)
    for t in range(DURATION):
        readings, now = sensors.readings({**ships.state, "psi": ships.psi}), ships.indicated
        if t:
            filters.update(readings, before, now)
        else:
            filters.begin(readings, np.arange(count))
        seen[t] = forecasts.observe(filters.mean, now)
        if t >= FROM and (t - FROM) % EVERY == 0:
            since = t - ships.own["when"]
            looked = ~ships.own["lapse"] | ((since > -AROUND[0]) & (since < AROUND[1]))
            told.append(forecasts.columns(filters.normal(), now, ships.alive & looked))
        before, states[t] = now, np.stack([ships.state[name] for name in STATE])
        hands.steer(t)
        ships.step()
    columns = {name: np.array([row[name] for row in told], np.float32) for name in COLUMNS}
    met = np.flatnonzero(~ships.alive)
    last = np.clip(ships.contact[met].astype(int)[:, None] - np.arange(BEFORE, 0, -1), 0, DURATION - 1)
    history = states[last, :, met[:, None]]
    outcome = {"struck": ships.contact, "least": ships.least, "lapse": ships.own["lapse"], "kind": ships.own["kind"]}
    return {
        **columns,
        **outcome,
        "when": ships.own["when"],
        "met": met,
        "history": history,
        "seen": seen,
        "hand": ships.own["hand"],
    }


def averted(physics: Physics, seed: int, run: Run, met: np.ndarray, acts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Whether ships (places among those that met a bank) stay clear if somebody acts at a time, and by how much [m].

    A person acts on the true state by the escape, an order a second, while everything else goes
    on as it did; who would act after the contact averts nothing.
    """
    which = run["met"][met]
    since = (acts - (run["struck"][which] - BEFORE)).astype(int)
    tries = np.flatnonzero((since < BEFORE) & np.isfinite(acts))
    clear, left = np.zeros(len(met), bool), np.zeros(len(met))
    if not len(tries):
        return clear, left
    rows = run["history"][met[tries], np.maximum(since[tries], 0)].astype(float)
    state = dict(zip(STATE, rows.T, strict=True))
    start = np.where(since[tries] < 0, run["struck"][which[tries]] - BEFORE, acts[tries])
    ships = departing(physics, ABREAST, seed).taken(which[tries], state, start, seed + 2)
    limit = ships.model.configuration.gear.limit
    law = escape_numbers(0.0, LENGTH, limit)
    for _ in range(ESCAPED):
        _escape(ships, law, limit)
        ships.step()
    clear[tries], left[tries] = ships.alive, np.where(ships.alive, ships.least, 0.0)
    return clear, left


def _escape(ships: Ships, law: dict[str, float], limit: float) -> None:
    state = ships.state
    course = np.clip((law["line"] - state["y"]) * law["reach"], -law["approach"], law["approach"])
    u = np.maximum(state["u"], 0.1)
    turn = (state["r"] - ships.bend * state["u"]) * law["by_r"] / u
    state["order"] = np.clip(-law["by_psi"] * (ships.psi + ships.across / u - course) - turn, -limit, limit)


def kept_runs(physics: Physics, number: int, parts: range, folder: Path | None) -> Iterator[tuple[int, Run]]:
    """Runs of a kind with their seeds; those that are kept in the folder are not sailed again."""
    for part in parts:
        path, seed = folder / f"{number}-{part:03d}.npz" if folder else None, 1000 * number + part
        if path and path.exists():
            with np.load(path) as kept:
                yield seed, dict(kept)
            continue
        run = watched(physics, seed)
        if path:
            path.parent.mkdir(parents=True, exist_ok=True)
            unfinished = path.with_suffix(".part.npz")
            np.savez_compressed(unfinished, **run)
            unfinished.rename(path)
        yield seed, run
