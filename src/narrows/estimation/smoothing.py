"""Estimates from whole records: the filter forward, with the coefficients among its states, then the smoother back."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from narrows.errors import InputError
from narrows.estimation.filter_run import Records
from narrows.estimation.recursion import DriftMonitor
from narrows.estimation.settings import SAME_TIME, START_READINGS
from narrows.estimation.ship_filter import ShipFilter, Start
from narrows.estimation.unscented import Gaussian, Transformed


class Smoothed(NamedTuple):
    mean: np.ndarray  # (times, states) Estimates; NaN before the start
    covariance: np.ndarray  # (times, states, states) Covariances of their errors
    refused: dict[str, np.ndarray]  # (times,) True if a sensor's reading was refused
    suspected: dict[str, np.ndarray]  # (times,) True if a sensor's innovations had a bias
    resets: tuple[float, ...]  # Times at which the estimate lay in a bank and restarted [s]


class _Chain:
    """A run of the filter without a break: its stages, and those that start at times of the records."""

    def __init__(self, first: Gaussian) -> None:
        self.stages: list[Stage] = []
        self.now = first
        self.asked: list[tuple[int, int]] = []


def smooth(filter: ShipFilter, records: Records) -> Smoothed:
    """Estimate states from all readings, before and after."""
    # The coefficients are states too, with the fit's covariance as prior: a whole record may correct them.
    joint = replace(filter, coefficients="estimated", memory=math.inf)
    pass_ = _Pass(joint, records)
    chains = pass_.chains()
    if not chains:
        lacking = f"these records lack {pass_.start.lacking}"
        raise InputError(f"{lacking}; an estimate starts from {START_READINGS} readings of each")
    size, count = len(filter.states), len(records.t)
    mean, covariance = np.full((count, size), np.nan), np.full((count, size, size), np.nan)
    for chain in chains:
        back = smoothed(chain.stages, chain.now)
        for row, stage in chain.asked:
            mean[row], covariance[row] = back[stage][0][:size], back[stage][1][:size, :size]
    return Smoothed(mean, covariance, pass_.refused, pass_.suspected, tuple(pass_.resets))


class _Pass:
    """The filter over all records, in the order of measurement."""

    def __init__(self, filter: ShipFilter, records: Records) -> None:
        self.filter, self.records, self.resets = filter, records, list[float]()
        shape = len(records.t)
        self.refused = {name: np.zeros(shape, bool) for name in filter.sensors}
        self.suspected = {name: np.zeros(shape, bool) for name in filter.sensors}
        self.start, self.monitor = Start(filter), filter.monitor()
        rest = filter.ship.values()
        known = {
            name: _held(records.positions.get(name), float(rest.get(name) or 0.0), shape) for name in filter.actuators
        }
        self.positions = np.stack([known[name] for name in filter.actuators], axis=1) if known else np.zeros((shape, 0))

    def position(self, t: float) -> np.ndarray:
        """Indicated positions at a time, linear between the rows."""
        return np.array([np.interp(t, self.records.t, column) for column in self.positions.T])

    def events(self) -> list[tuple[float, dict[str, tuple[int, np.ndarray]], int]]:
        """Times in order, the readings at each (with their row), and the row that needs the state there or -1."""
        found: dict[float, tuple[dict[str, tuple[int, np.ndarray]], int]] = {}
        for row, (t, told, _) in enumerate(self.records.rows()):
            found[t] = (found[t][0] if t in found else {}, row)
            for name, reading in told.items():
                measured = t - self.filter.sensors[name].late
                found.setdefault(measured, ({}, -1))[0][name] = (row, reading)
        return [(t, *found[t]) for t in sorted(found)]

    def chains(self) -> list[_Chain]:
        """Run the filter; one chain for each stretch between resets."""
        chains: list[_Chain] = []
        chain: _Chain | None = None
        last = math.nan
        for t, told, row in self.events():
            if chain is not None and t - last > SAME_TIME and not self._moved(chain, last, t):
                self.resets.append(t)
                chain, self.start, self.monitor = None, Start(self.filter), self.filter.monitor()
            if chain is None:
                self.start.add(t, {name: tuple(reading) for name, (_, reading) in told.items()})
                if self.start.lacking:
                    continue
                chain = _Chain(self.start.state(t))
                chains.append(chain)
            elif told:
                self._corrected(chain, told, self.monitor)
            last = t
            if row >= 0:
                chain.asked.append((row, len(chain.stages)))
        return chains

    def _moved(self, chain: _Chain, start: float, end: float) -> bool:
        now = chain.now
        for step in self.filter.steps(now, end - start, self.position(start), self.position(end)):
            if step.aground:
                return False
            chain.stages.append(Stage(now, step.how, step.state))
            now = step.state
        chain.now = now
        return True

    def _corrected(self, chain: _Chain, told: dict[str, tuple[int, np.ndarray]], monitor: DriftMonitor) -> None:
        readings = {name: tuple(reading.tolist()) for name, (_, reading) in told.items()}
        believed = self.filter.recursion.update(chain.now, readings, monitor)
        chain.now = believed.state
        for flags, names in ((self.refused, believed.refused), (self.suspected, believed.suspects)):
            for name in names:
                flags[name][told[name][0]] = True


def _held(column: np.ndarray | None, rest: float, count: int) -> np.ndarray:
    """Latest indicated positions; at rest before."""
    if column is None:
        return np.full(count, rest)
    known = np.where(np.isfinite(column), np.arange(count), -1)
    latest = np.maximum.accumulate(known)
    return np.where(latest >= 0, column[latest], rest)


# Rauch, Tung and Striebel (1965), Maximum likelihood estimates of linear dynamic systems. Sarkka (2008), Unscented
# Rauch-Tung-Striebel smoother.
class Stage(NamedTuple):
    """A step of the filter, for the smoother."""

    before: Gaussian  # State from the readings until then
    moved: Transformed  # Its transformation by the motion
    after: Gaussian  # State after the motion, before the next readings


def smoothed(stages: Sequence[Stage], last: Gaussian) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return means and covariances at the start of each stage and at the end of the last."""
    mean, covariance = last.mean, last.covariance
    found = [(mean, covariance)]
    for stage in reversed(stages):
        size = stage.before.root.shape[1]
        # Columns of the root after those of the state are disturbances: their effect is in the state after.
        shared = stage.before.root @ stage.moved.slopes[:size]
        ahead = stage.after.covariance
        gain = np.linalg.lstsq(ahead, shared.T, rcond=None)[0].T
        mean = stage.before.mean + gain @ (mean - stage.after.mean)
        covariance = stage.before.covariance + gain @ (covariance - ahead) @ gain.T
        covariance = (covariance + covariance.T) / 2
        found.append((mean, covariance))
    return found[::-1]
