"""Estimates from whole records: the filter forward, with the coefficients among its states, then the smoother back."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from narrows.errors import InputError
from narrows.estimation.estimate import EstimatedTrack
from narrows.estimation.filter_run import AGROUND, FilterRun, Moment, Readings
from narrows.estimation.records import rows_of
from narrows.estimation.settings import START_READINGS
from narrows.estimation.ship_filter import MotionStep, ShipFilter
from narrows.estimation.start import Start
from narrows.estimation.unscented import Gaussian

if TYPE_CHECKING:
    import pandas as pd


def smooth(filter: ShipFilter, records: "pd.DataFrame", notes: tuple[str, ...]) -> EstimatedTrack:
    """Return states by all readings, before and after; where the estimate lay in a bank it begins anew."""
    # The coefficients are states too, with the fit's covariance as prior: a whole record may correct them.
    joint, count, size = replace(filter, coefficients="estimated", memory=math.inf), len(records), len(filter.states)
    refused, suspected = ({name: np.zeros(count, bool) for name in filter.sensors} for _ in range(2))
    held = (
        records[list(filter.actuators)]
        .ffill()
        .fillna(dict(zip(filter.actuators, joint.at_rest, strict=True)))
        .to_numpy()
    )
    start, run, times = Start(joint), None, records.index.to_numpy()
    # Filter runs between resets, with the rows of the records and the places of their moments in the run's history.
    runs: list[tuple[FilterRun, list[tuple[int, int]]]] = []
    for t, readings, rows, row in _events(joint, records):
        at = np.array([np.interp(t, times, column) for column in held.T])
        if run and run.advance(t, at, readings):
            for result in run.results:
                for flags, names in ((refused, result.refused), (suspected, result.suspects)):
                    for name in names:
                        flags[name][rows[name]] = True
            run.results.clear()
        else:
            if run:
                notes, run, start = (*notes, AGROUND.format(t)), None, Start(joint)
            start.add(t, readings)
            if start.missing:
                continue
            run = FilterRun(joint, [Moment(t, start.state(t), at, {}, joint.monitor())], 0.0, math.inf)
            runs.append((run, []))
        if row >= 0:
            runs[-1][1].append((row, len(run.history) - 1))
    if not runs:
        raise InputError(
            f"these records lack {start.missing}; an estimate starts from {START_READINGS} readings of each"
        )
    mean, covariance = np.full((count, size), np.nan), np.full((count, size, size), np.nan)
    for run, places in runs:
        back = smoothed([step for moment in run.history for step in moment.steps], run.last.state)
        until = np.cumsum([len(moment.steps) for moment in run.history])
        for row, moment in places:
            mean[row], covariance[row] = back[until[moment]][0][:size], back[until[moment]][1][:size, :size]
    known = np.isfinite(mean[:, 0])
    mean[:, 2] = (mean[:, 2] + np.pi) % (2 * np.pi) - np.pi
    refused, suspected = ({name: flag[known] for name, flag in by.items()} for by in (refused, suspected))
    t, ready = times[known], np.ones(known.sum(), bool)
    return EstimatedTrack(
        t, mean[known], covariance[known], filter.states.names, ready, refused, suspected, True, notes
    )


def _events(filter: ShipFilter, records: "pd.DataFrame") -> list[tuple[float, Readings, dict[str, int], int]]:
    """Times of measurement in order: the readings, their rows, and the row that needs the state there, or -1."""
    found: dict[float, tuple[Readings, dict[str, int], int]] = {}
    for row, (t, measured) in enumerate(rows_of(records, filter.sensors, ())):
        found[t] = (*found.get(t, ({}, {}))[:2], row)
        for name, reading in measured.items():
            readings, rows, _ = found.setdefault(t - filter.sensors[name].late, ({}, {}, -1))
            readings[name], rows[name] = reading, row
    return [(t, *found[t]) for t in sorted(found)]


def smoothed(steps: Sequence[MotionStep], last: Gaussian) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return means and covariances at the start of each step of the filter and at the end of the last."""
    # Rauch, Tung and Striebel (1965), Maximum likelihood estimates of linear dynamic systems. Sarkka (2008), Unscented
    # Rauch-Tung-Striebel smoother.
    mean, covariance = last.mean, last.covariance
    found = [(mean, covariance)]
    for step in reversed(steps):
        size = step.before.root.shape[1]
        # Columns of the root after those of the state are disturbances: their effect is in the state after.
        shared = step.before.root @ step.slopes[:size]
        ahead = step.state.covariance
        gain = np.linalg.lstsq(ahead, shared.T, rcond=None)[0].T
        mean = step.before.mean + gain @ (mean - step.state.mean)
        covariance = step.before.covariance + gain @ (covariance - ahead) @ gain.T
        covariance = (covariance + covariance.T) / 2
        found.append((mean, covariance))
    return found[::-1]
