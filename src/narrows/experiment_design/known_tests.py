"""What tests that were made tell a plan: their information, and which speeds and offsets were tried."""

from dataclasses import replace

import numpy as np

from narrows.experiment_design.candidates import Tank
from narrows.experiment_design.information import zero_columns, zero_of
from narrows.identification.fit import Fit
from narrows.identification.regression.problem import slots
from narrows.identification.uncertainty.error_model import whitened
from narrows.model.data_range import DataRange
from narrows.terms.term import TermTable

# Highest speed over lowest, less one, within which tests were at one speed.
ALIKE = 0.05


def within_tested(tank: Tank, tested: DataRange | None) -> tuple[Tank, tuple[str, ...]]:
    """Return a tank at the speeds and offsets that were tested, where none were asked for."""
    notes = []
    if tested is not None and tested.speed is not None and not tank.speeds:
        low, high = tested.speed
        speeds = (low,) if high - low < ALIKE * high else (low, (low + high) / 2, high)
        tank = replace(tank, speeds=tuple(round(speed, 3) for speed in speeds if round(speed, 3) > 0))
        notes.append(f"Speeds are within those tested, {low:.3g} to {high:.3g} m/s, as none were asked for.")
    if tested is not None and tested.abs_y is not None and tested.abs_y[1] > 0 and tank.reach is None:
        tank = replace(tank, reach=tested.abs_y[1])
        notes.append(f"Offsets are within those tested, {tested.abs_y[1]:.3g} m, as no reach was asked for.")
    return tank, tuple(notes)


def known_information(
    made: list[Fit], tables: list[TermTable], shape: tuple[int, ...]
) -> tuple[np.ndarray, np.ndarray]:
    """Return information of tests that were made, and D'D and D'VD of the first table, by the errors of fits."""
    count = max(slots(tables[0]).values()) + 1
    information, grams = np.zeros(shape), np.zeros((2, count, count))
    for i, fit in enumerate(made):
        model, level = fit.error_model, fit.error_model.level
        d = level.d * fit.problem.scale
        zero = zero_of(fit.motions.steady, fit.motions.features["side"])
        columns = np.concatenate([d, zero_columns(level.one, level.force, zero[level.motion])], axis=2)
        white = whitened(model.covariance, columns).reshape(-1, columns.shape[2])
        information[i] = white.T @ white
        if i == 0:
            flat = d.reshape(-1, d.shape[2])
            grams[0], grams[1] = flat.T @ flat, flat.T @ (model.covariance @ d).reshape(flat.shape)
    return information, grams
