"""The model that a record makes: coefficients, covariance, verdicts, their source, and what the record covered."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from narrows.logbook.learned_coefficient import LearnedCoefficient, verdicts_after
from narrows.model.data_range import DataRange, Range
from narrows.model.model import Model


def learned_model(
    prior: Model, coefficients: Mapping[str, LearnedCoefficient], covariance: np.ndarray, source: str,
    offsets: Range, speeds: Range, contradicted: bool = False,
) -> Model:  # fmt: skip
    """Return the model after a record."""
    # covariance (n, n); offsets [m]; speeds [m/s]
    return replace(
        prior,
        coefficients={name: coefficient.value for name, coefficient in coefficients.items()},
        covariance=(covariance + covariance.T) / 2,
        data_range=covered_range(prior, offsets, speeds),
        source=replace(prior.source, text="; ".join(filter(None, (prior.source.text, source)))),
        verdicts=verdicts_after(prior, coefficients, contradicted),
    )


def covered_range(prior: Model, offsets: Range, speeds: Range) -> DataRange:
    """Return what tests and record cover together."""
    # offsets [m]; speeds [m/s]
    # In a section that no test had, the record alone says how far off the middle and how fast the bank was met; slower
    # than that, its force is less. Where no bank is felt, speeds count alone.
    known, configuration = prior.data_range, prior.configuration
    section = {"width_to_beam": configuration.canal.width / configuration.ship.beam}
    if configuration.canal.depth is not None:
        section["depth_to_draft"] = configuration.canal.depth / configuration.ship.draft
    if not prior.feels_bank:
        low, high = known.speed or speeds
        return replace(known, speed=(min(speeds[0], low), max(speeds[1], high)))
    new = any(getattr(known, name) is None or known.outside(name, ratio) for name, ratio in section.items())
    slowest = min(speeds[0], (known.speed or speeds)[0])
    fastest = speeds[1] if new else max(speeds[1], (known.speed or speeds)[1])
    farthest = offsets[1] if new else max(offsets[1], (known.abs_y or offsets)[1])
    nearest = 0.0 if new else min(offsets[0], (known.abs_y or offsets)[0])
    here = {name: (ratio, ratio) for name, ratio in section.items()} if new else {}
    return replace(known, speed=(slowest, fastest), abs_y=(nearest, farthest), **here)
