"""A model of one depth taken to another: the few corrections there are, and what they leave out."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from narrows.errors import InputError
from narrows.model.model import Model
from narrows.physics import shallow
from narrows.quantities.names import Number, asked_by
from narrows.ship.particulars import Configuration

FACTORS: Mapping[str, Callable[..., Number]] = {
    "b_v": shallow.kijima_drift_force,
    "b_uv": shallow.kijima_drift_force,
    "c_v": shallow.kijima_drift_moment,
    "c_uv": shallow.kijima_drift_moment,
    "c_r": shallow.kijima_yaw_moment,
    "c_ur": shallow.kijima_yaw_moment,
}
"""Which coefficient grows by which factor over deep water."""
UNVERIFIED = ("c_v", "c_uv")
SHALLOWEST = 1.5
"""h/T below which the corrections miss what was measured: the force of drift by half, on the KCS at 1.2."""
DEEP = 1e9
"""A depth [m] at which every factor is 1."""


@dataclass(frozen=True)
class AtDepth:
    """A model taken to another depth.

    Parameters
    ----------
    model : Model
        With the corrected coefficients and the new depth.
    factors : mapping of str to float [1]
        By which each corrected coefficient was multiplied.
    warnings : tuple of str
        What was not corrected, and what is not verified.
    """

    model: Model
    factors: Mapping[str, float]
    warnings: tuple[str, ...]


def factor_at(name: str, configuration: Configuration, depth: float) -> float:
    """Return the factor of a coefficient over deep water at a depth [1].

    Parameters
    ----------
    name : str
        One of ``FACTORS``.
    configuration : Configuration
        The ship.
    depth : float [m]
        Of the water.
    """
    function = FACTORS[name]
    values = {**configuration.values(), "depth": depth}
    return float(function(*[values[word] for word in asked_by(function)]))


def at_depth(model: Model, depth: float) -> AtDepth:
    """Take a model to another depth by Kijima's corrections.

    Where the tests' own depth is not known they count as deep. Tests at the depth itself are better: the corrections
    know a few of the hull's coefficients and nothing of the bank.

    Parameters
    ----------
    model : Model
        Of one depth.
    depth : float [m]
        The new one.

    Raises
    ------
    InputError
        Where the depth leaves no water under the keel.
    """
    old = model.configuration
    if not depth > old.ship.draft:
        raise InputError(f"a depth of {depth} m leaves no water under a draft of {old.ship.draft} m; raise it")
    was = old.canal.depth or DEEP
    factors = {
        name: factor_at(name, old, depth) / factor_at(name, old, was) for name in model.terms.names if name in FACTORS
    }
    grown = np.array([factors.get(name, 1.0) for name in model.terms.names])
    moved = replace(
        model,
        configuration=replace(old, canal=replace(old.canal, depth=depth)),
        coefficients={name: value * factors.get(name, 1.0) for name, value in model.coefficients.items()},
        covariance=None if model.covariance is None else model.covariance * np.outer(grown, grown),
        data_range=replace(model.data_range, depth_to_draft=None),
        source=replace(model.source, text=f"{model.source.text}; taken to h/T = {depth / old.ship.draft:.2f} (Kijima)"),
    )
    return AtDepth(moved, factors, _warnings(model, factors, depth))


def _warnings(model: Model, factors: Mapping[str, float], depth: float) -> tuple[str, ...]:
    kept = [name for name in model.terms.names if name not in factors and name[0] != "a"]
    said = [f"Left as they were: {', '.join(kept)}."]
    unverified = [name for name in factors if name in UNVERIFIED]
    if unverified:
        said.append(f"The exponent for {', '.join(unverified)} is from memory, not verified.")
    if model.configuration.canal.depth is None:
        said.append("The depth of the tests is not known; they were taken as deep water.")
    deeper = [term.name for term in model.terms.terms if "depth" in term.inputs]
    if deeper:
        said.append(f"The terms of {', '.join(deeper)} ask for the depth: tests at one depth do not determine them.")
    ratio = depth / model.configuration.ship.draft
    if ratio < SHALLOWEST:
        said.append(
            f"h/T = {ratio:.2f} is below {SHALLOWEST}, where the factors grow without limit and none was measured."
        )
    if any(factor < 1 for factor in factors.values()) and depth < (model.configuration.canal.depth or DEEP):
        said.append("A factor below 1 in shallower water is outside of what the corrections were made for.")
    return tuple(said)
