"""What every exported file says of its model: whose it is, what its tests covered, how far they settle it."""

import hashlib
import json
import math
from collections.abc import Iterable, Iterator
from importlib.metadata import version

from narrows.model.data_range import MEASURES, SLACK
from narrows.model.model import Model

# What moves in a voyage, by its bit in the sum ``beyond``.
BEYOND = {name: (MEASURES[name].bit, MEASURES[name].short) for name in ("speed", "abs_y", "abs_psi", "abs_r")}
# What a question of the bank's force has, beside its size in the unit of its range.
ASKED_OF_BANK = ("speed", "abs_y", "abs_psi", "width_to_beam", "depth_to_draft")
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


def ends_of_data(model: Model, names: Iterable[str] = tuple(BEYOND)) -> dict[str, tuple[int, float, float]]:
    """Return of each measure its bit, and between which ends it is within the data, widths and depths in metres."""
    ends, ship = {}, model.configuration.ship
    scales = {"width_to_beam": ship.beam, "depth_to_draft": ship.draft}
    for name in names:
        pair = getattr(model.data_range, name)
        if pair is not None:
            slack, scale = SLACK * max(map(abs, pair)), scales.get(name, 1.0)
            ends[name] = (MEASURES[name].bit, scale * (pair[0] - slack), scale * (pair[1] + slack))
    return ends
