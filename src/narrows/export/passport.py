"""What every exported file says of its model: whose it is, what its tests covered, how far they settle it."""

import hashlib
import json
import math
from collections.abc import Iterator
from importlib.metadata import version

from narrows.model.data_range import MEASURES, SLACK
from narrows.model.model import Model

# What moves in a voyage and the tests covered, by its bit in the sum ``beyond``.
BEYOND = {
    "speed": (1, "speed"), "abs_y": (2, "offset"), "abs_psi": (4, "heading"), "abs_r": (8, "yaw rate"),
}  # fmt: skip
LICENCE = "This file may be used, changed and passed on freely, for any purpose, without warranty."
HASH_DIGITS = 16


def model_hash(model: Model) -> str:
    """Return the first digits of the SHA-256 of a model's sections, the same on every machine."""
    text = json.dumps(model.to_dict(), sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:HASH_DIGITS]


def passport(model: Model) -> Iterator[str]:
    """Say in a few lines what a model is, where it is from, and how far it can be trusted."""
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


def _coefficients(model: Model) -> Iterator[str]:
    if model.covariance is None:
        yield "Its coefficients have no published uncertainty."
        return
    yield "Coefficients with their standard deviations:"
    for number, (name, term) in enumerate((name, model.terms[name]) for name in model.terms.names):
        deviation = math.sqrt(max(float(model.covariance[number, number]), 0.0))
        verdict = f", {model.verdicts[name]}" if name in model.verdicts else ""
        yield f"  {name} = {model[name]:.4g} +- {deviation:.2g} {term.dimension.unit}{verdict}"


def tested_ends(model: Model) -> dict[str, tuple[int, float, float]]:
    """Return of each measure of the motion its bit, and between which ends it is within the data."""
    ends = {}
    for name, (bit, _) in BEYOND.items():
        pair = getattr(model.data_range, name)
        if pair is not None:
            slack = SLACK * max(map(abs, pair))
            ends[name] = (bit, pair[0] - slack, pair[1] + slack)
    return ends
