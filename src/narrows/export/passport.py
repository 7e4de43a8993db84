"""The passport of every exported file: the model's origin, its tested range, its uncertainty."""

import hashlib
import json
import math
from collections.abc import Iterable, Iterator
from importlib.metadata import version
from textwrap import wrap

import numpy as np

from narrows.model.data_range import MEASURES, tolerated
from narrows.model.model import Model

# Quantities that move in a voyage, by their bit in the sum ``beyond``.
BEYOND = {name: (MEASURES[name].bit, MEASURES[name].short) for name in ("speed", "abs_y", "abs_psi", "abs_r")}
# A speed at which the ship touches the bottom or chokes the section, which ends a voyage of ``simulate``.
BEYOND |= {"bottom": (128, "bottom")}
# Inputs of the bank's force, by size in the unit of the range.
ASKED_OF_BANK = ("speed", "abs_y", "abs_psi", "width_to_beam", "depth_to_draft")
LICENCE = "This file may be used, changed and passed on freely, for any purpose, without warranty."
HASH_DIGITS = 16
# Normal distribution: 95 % lie within this many standard deviations.
NORMAL_95 = 1.959964
WIDTH = 100


def model_hash(model: Model) -> str:
    """Return the first digits of the SHA-256 of a model's sections, the same on every machine."""
    text = json.dumps(model.to_dict(), sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:HASH_DIGITS]


def passport(model: Model, covariance: bool = True) -> Iterator[str]:
    """Describe a model in a few lines: its kind, origin, and trust."""
    ship = model.configuration.ship
    yield f"{ship.name}: motion between two banks by the terms {model.terms.name}."
    yield f"Model {model_hash(model)}, written by narrows {version('narrows')}. {LICENCE}"
    if model.source.text:
        yield f"Source: {model.source.text}."
    yield from model.notes
    covered = [
        f"{measure.words} {measure.shown(*pair)}"
        for name, measure in MEASURES.items()
        if (pair := getattr(model.data_range, name)) is not None
    ]
    yield f"Its tests covered: {'; '.join(covered)}." if covered else "The model does not say what its tests covered."
    yield from _coefficients(model)
    if covariance and model.covariance is not None:
        yield "Covariance of the coefficients in this order, the lower triangle row by row, in their units:"
        triangle = ", ".join(f"{value:.9g}" for value in model.covariance[np.tril_indices(len(model.terms))])
        yield from (f"  {line}" for line in wrap(triangle, WIDTH))


def _coefficients(model: Model) -> Iterator[str]:
    if model.covariance is None:
        yield "Its coefficients have no published uncertainty."
        return
    yield "Coefficients with 95 % intervals:"
    for name, variance in zip(model.terms.names, np.diag(model.covariance), strict=True):
        term, value, half = model.terms[name], model[name], NORMAL_95 * math.sqrt(max(variance, 0.0))
        low, high = max(value - half, term.bound[0]), min(value + half, term.bound[1])
        verdict = f", {model.verdicts[name]}" if name in model.verdicts else ""
        yield f"  {name} = {value:.4g} ({low:.4g} to {high:.4g}) {term.dimension.unit}{verdict}"


def ends_of_data(model: Model, names: Iterable[str]) -> dict[str, tuple[int, float, float]]:
    """Return for each measure its bit and the limits of the data, widths and depths in metres."""
    ends, ship = {}, model.configuration.ship
    scales = {"width_to_beam": ship.beam, "depth_to_draft": ship.draft}
    for name in names:
        pair = model.data_range.range_of(name)
        if pair is not None:
            (low, high), scale = tolerated(pair), scales.get(name, 1.0)
            ends[name] = (MEASURES[name].bit, scale * low, scale * high)
    return ends
