"""Accelerations consistent with the measured motion: five harmonics of a run's period, or zero without oscillation.

Noise in a regressor does not average out: it biases its coefficient towards zero, and others with it. The velocities of
a periodic run, projected on few harmonics and differentiated, have almost none.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Literal, NamedTuple, get_args

import numpy as np

from narrows.base.errors import check_choice
from narrows.captive import settings
from narrows.captive.tests import CaptiveTests

Accelerations = Literal["checked", "motion", "measured"]
CHOICES = get_args(Accelerations)
RATES = {"u": "udot", "v": "vdot", "r": "rdot"}
# Standard deviations below which a run does not oscillate: relative to the speed, in radians, relative to the length.
LEAST_MOTION = {"v": 0.01, "psi": 0.01, "y": 0.01}
# Least number of rows in a run: two for each fitted number.
FEWEST = 2 * (2 * settings.HARMONICS + 1)


class HarmonicMotion(NamedTuple):
    frequency: float = 0.0  # Angular frequency of the first harmonic; 0 without oscillation [rad/s]
    # Cosines, then sines, (2 x HARMONICS,), of each velocity that they explain, and the approximate size of the
    # acceleration of higher harmonics, in its unit
    harmonics: Mapping[str, tuple[np.ndarray, float]] = MappingProxyType({})

    def acceleration(self, velocity: str, t: np.ndarray) -> np.ndarray:
        # t (rows,) [s]
        cosine, sine = np.split(self.harmonics[velocity][0], 2)
        rates = self.frequency * np.arange(1, len(sine) + 1)
        angles = np.outer(t, rates)
        return np.asarray(np.cos(angles) @ (rates * sine) - np.sin(angles) @ (rates * cosine))


def with_accelerations(tests: CaptiveTests, choice: str = "checked") -> CaptiveTests:
    """Return tests whose accelerations are replaced where the measured ones contradict the motion."""
    check_choice("accelerations", choice, CHOICES)
    columns = tests.columns
    pairs = {v: rate for v, rate in RATES.items() if {v, rate} <= columns.keys()}
    if not {"t", "y", "psi", "u"} <= columns.keys() or not pairs:
        return tests
    runs = [tests.rows_of(i) for i in range(len(tests.names))]
    length = tests.configuration.ship.length
    small = {velocity: _small(columns, velocity, length) for velocity in pairs}
    motions = [
        HarmonicMotion() if choice != "motion" and _agree(run, small) else motion_of(run, length) for run in runs
    ]
    new, notes = dict(columns), []
    for velocity, rate in pairs.items():
        stray = np.array([_stray(*pair, velocity) for pair in zip(runs, motions, strict=True)]) / small[velocity]
        far = stray > 1
        if far.any():
            notes.append(_sentence(rate, tests.names, settings.ACCELERATION_TOLERANCE * stray, far, choice))
        chosen = np.isfinite(stray) if choice == "motion" else far
        if choice != "measured" and chosen.any():
            new[rate] = new[rate].copy()
            for i in np.flatnonzero(chosen):
                t = runs[i]["t"]
                new[rate][tests.starts[i] : tests.starts[i + 1]] = motions[i].acceleration(velocity, t - t[0])
    return replace(tests, columns=new, notes=(*tests.notes, *notes))


def motion_of(run: Mapping[str, np.ndarray], length: float) -> HarmonicMotion:
    if not (few := _sampled(run)):
        return HarmonicMotion()
    t, speed = few["t"] - few["t"][0], max(float(np.abs(few["u"]).mean()), 1e-9)
    size = {"v": speed, "psi": 1.0, "y": length}
    moving = {name: float(np.std(few[name])) / size[name] / part for name, part in LEAST_MOTION.items() if name in few}
    frequency = 0.0
    if max(moving.values()) > 1:
        frequency = _frequency(t, few[max(("y", "psi"), key=lambda name: moving[name])])
    usual = {"u": 0.01 * speed, "v": 0.01 * speed, "r": 0.01 * speed / length}
    fitted = {name: _harmonics(t, few[name], frequency, usual[name]) for name in RATES if name in few}
    return HarmonicMotion(frequency, {name: harmonics for name, harmonics in fitted.items() if harmonics is not None})


def _sampled(run: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return some rows of a run; none of a run too short for harmonics, or whose time runs back."""
    step = max(1, len(run["t"]) // settings.SAMPLED)
    few = {name: column[::step] for name, column in run.items()}
    return few if len(few["t"]) >= FEWEST and (np.diff(few["t"]) > 0).all() else {}


def _frequency(t: np.ndarray, column: np.ndarray) -> float:
    """Frequency whose harmonics leave the smallest residual, searched from the largest line of the spectrum."""
    from scipy.optimize import minimize_scalar

    span = t[-1] + float(np.median(np.diff(t)))
    even = np.interp(np.linspace(0, t[-1], len(t)), t, column - column.mean())
    line = 1 + int(np.abs(np.fft.rfft(even))[1:].argmax())
    low, high = (2 * np.pi / span * max(0.4, line + by) for by in (-0.75, 0.75))
    for harmonics in (1, settings.HARMONICS):
        minimum = minimize_scalar(
            lambda w, n=harmonics: _rest(t, column, w, n)[1].var(), bounds=(low, high), method="bounded",
            options={"xatol": 1e-7 * high},
        )  # fmt: skip
        low, high = minimum.x * 0.98, minimum.x * 1.02
    return float(minimum.x)


def _rest(t: np.ndarray, column: np.ndarray, frequency: float, harmonics: int) -> tuple[np.ndarray, np.ndarray]:
    """Constant, cosines and sines of a column by least squares, and the residual."""
    angles = np.outer(t, frequency * np.arange(1, harmonics + 1))
    basis = np.hstack([np.ones((len(t), 1)), np.cos(angles), np.sin(angles)])
    parts = np.linalg.lstsq(basis, column, rcond=1e-10)[0]
    return parts, column - basis @ parts


def _harmonics(t: np.ndarray, column: np.ndarray, frequency: float, typical: float) -> tuple[np.ndarray, float] | None:
    """Cosines and sines of a velocity above their noise, and the missing acceleration."""
    # None if they do not explain it.
    parts, rest = np.zeros(1), column - column.mean()
    if frequency:
        parts, rest = _rest(t, column, frequency, settings.HARMONICS)
    error = float(rest.std())
    memory = float(rest[1:] @ rest[:-1]) / max(float(rest @ rest), 1e-300)
    if error > settings.SMALL_REST * max(float(column.std()), typical) and memory > settings.WHITE:
        return None
    if not frequency:
        return np.zeros(2 * settings.HARMONICS), 0.0
    pairs = parts[1:].reshape(2, settings.HARMONICS)
    # Below 1e-9 of a usual size it is rounding of a constant.
    least = max(settings.SIGNIFICANT * 4 * error**2 / len(t), (1e-9 * typical) ** 2)
    silent = (pairs**2).sum(axis=0) < least
    missing = (settings.HARMONICS + 2) * frequency * error if memory > settings.WHITE else 0.0
    return np.where(silent, 0.0, pairs).ravel(), missing


def _small(columns: Mapping[str, np.ndarray], velocity: str, length: float) -> float:
    """Tolerance of a measured acceleration: a share of its size in the table."""
    arm = length**2 if velocity == "r" else length
    least = settings.LEAST_ACCELERATION * float(np.mean(columns["u"] ** 2)) / arm
    return settings.ACCELERATION_TOLERANCE * max(float(np.sqrt(np.mean(columns[RATES[velocity]] ** 2))), least)


def _agree(run: Mapping[str, np.ndarray], small: Mapping[str, float]) -> bool:
    """Return whether differences of the velocities already give the measured accelerations, as without noise."""
    few = _sampled(run)
    return not few or all(
        np.mean((np.gradient(few[velocity], few["t"]) - few[RATES[velocity]]) ** 2) <= most**2
        for velocity, most in small.items()
    )


def _stray(run: Mapping[str, np.ndarray], motion: HarmonicMotion, velocity: str) -> float:
    """Difference of a measured acceleration from that of the motion; NaN if unknown."""
    if velocity not in motion.harmonics:
        return math.nan
    few = _sampled(run)
    away = few[RATES[velocity]] - motion.acceleration(velocity, few["t"] - few["t"][0])
    size = float(np.sqrt(np.mean(away**2)))
    return size if size > 2 * motion.harmonics[velocity][1] else 0.0


def _sentence(rate: str, names: tuple[str, ...], stray: np.ndarray, far: np.ndarray, choice: str) -> str:
    others = f" and {far.sum() - 1} more" if far.sum() > 1 else ""
    biased = "used as measured, which biases their coefficients towards 0"
    done = biased if choice == "measured" else "taken from the motion"
    where = f"in test {names[int(np.nanargmax(stray))]}{others}"
    return f"Measured {rate} differs from the motion by {np.nanmax(stray):.0%} of its size {where}: it is {done}."
