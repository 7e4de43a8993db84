"""The passport of every exported file: the model's origin, its tested range, its uncertainty."""

import hashlib
import json
import math
from collections.abc import Container, Iterator, Mapping
from importlib.metadata import version
from textwrap import wrap

import numpy as np

from narrows.model.bank_force import ALONG
from narrows.model.data_range import MEASURES, DataRange, range_of, tolerated, unknown_note, unknown_ranges
from narrows.model.model import Model

# Quantities of a voyage, by their bit in the sum ``beyond``.
RANGE_BITS = {name: (one.bit, one.short) for name, one in sorted(MEASURES.items(), key=lambda item: item[1].bit)}
# A speed at which the ship touches the bottom or chokes the section, which ends a voyage of ``simulate``.
RANGE_BITS |= {"bottom": (128, "bottom")}
# Quantities of a voyage and of the bank's force, each with the part that sets no bit where its range is unknown.
ASKED_OF_VOYAGE = {**dict.fromkeys(MEASURES, ""), "speed": " ahead"}
ASKED_OF_BANK = {
    "speed": " ahead", "abs_y": "", "abs_psi": f" up to {math.degrees(ALONG):.0f} deg", "width_to_beam": "",
    "depth_to_draft": "",
}  # fmt: skip
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
    where = "between two banks" if model.has_bank else "without a bank force"
    yield f"{ship.name}: motion {where}, by the terms {model.terms.name}."
    yield f"Model {model_hash(model)}, written by narrows {version('narrows')}. {LICENCE}"
    if model.source.text:
        yield f"Source: {model.source.text}."
    known, ranges = model.data_range, unknown_note(model.data_range, model.has_bank)
    yield from (note for note in model.notes if note != ranges)
    covered = [f"{one.words} {known.describe(name)}" for name, one in MEASURES.items() if getattr(known, name)]
    whose = "The other ships'" if model.source.estimate else "Its"
    if covered:
        yield f"{whose} tests covered: {'; '.join(covered)}."
    unknown = _unknown(model) if covered else []
    yield from [f"The model gives no tested range of {', '.join(unknown)}."] * bool(unknown)
    yield from ["What its tests covered is not known."] * (not covered)
    if not model.verdicts and not model.unknown_note:
        yield "How well tests determine its coefficients is not known: the model has no verdicts."
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


def _unknown(model: Model, asked: Mapping[str, str] = ASKED_OF_VOYAGE) -> list[str]:
    """Return the quantities whose tested range the model does not give; astern counts as not tested."""
    return [MEASURES[name].short + asked[name] for name in unknown_ranges(model.data_range, asked)]


def bits_in_words(model: Model, asked: Mapping[str, str] = ASKED_OF_VOYAGE) -> str:
    """Return the bits of ``beyond`` for some quantities, and which of them set none."""
    bits = ", ".join(f"{bit} {words}" for name, (bit, words) in RANGE_BITS.items() if name in asked)
    unknown = _unknown(model, asked)
    return bits + (f" (not known, sets no bit: {', '.join(unknown)})" if unknown else "")


def ends_of_data(known: DataRange, names: Container[str]) -> dict[str, tuple[int, float, float]]:
    """Return for each measure its bit and the limits of the data."""
    pairs = {name: range_of(known, name) for name in MEASURES if name in names}
    return {name: (MEASURES[name].bit, *tolerated(pair)) for name, pair in pairs.items() if pair is not None}
