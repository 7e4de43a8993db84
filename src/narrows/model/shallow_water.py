"""A model at another depth: the available corrections, and effects they ignore."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from narrows.aliases import accept_aliases
from narrows.errors import InputError
from narrows.model.model import Model
from narrows.quantities.names import argument_names
from narrows.results import BaseResult
from narrows.ship.particulars import Configuration
from narrows.terms.term import DepthLaw

if TYPE_CHECKING:
    import pandas as pd

# h/T below which the corrections contradict measurements: the drift force by half, for the KCS at 1.2.
SHALLOWEST = 1.5
# A depth [m] at which every factor is 1.
DEEP = 1e9


@dataclass(frozen=True, repr=False)
class DepthCorrected(BaseResult):
    """A model corrected for another depth.

    Parameters
    ----------
    model : Model
        Model with the corrected coefficients and the new depth.
    factors : mapping of str to float [1]
        Factors of the corrected coefficients.
    notes : tuple of str
        Uncorrected effects, and unverified corrections.

    Examples
    --------
    >>> sorted(nw.at_depth(kcs, 15.0).factors)[:1]
    ['N_r']
    """

    model: Model
    factors: Mapping[str, float]
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        return f"<Model taken to another depth: {self.summary()}>"

    def summary(self) -> str:
        """List the factors."""
        configuration = self.model.configuration
        grown = ", ".join(f"{name} times {factor:.3g}" for name, factor in self.factors.items())
        ratio = (configuration.canal.depth or DEEP) / configuration.ship.draft
        return f"Taken to h/T = {ratio:.3g}: {grown or 'nothing was corrected'}."

    def to_dict(self) -> dict[str, Any]:
        """Return everything by name."""
        return {
            "depth": self.model.configuration.canal.depth,
            "factors": dict(self.factors),
            "coefficients": dict(self.model.coefficients),
            "summary": self.summary(),
            "notes": list(self.notes),
        }

    def to_dataframe(self) -> "pd.DataFrame":
        """Return the coefficients as a table: one row each, with its factor and its new value."""
        import pandas as pd

        rows = {name: (self.factors.get(name, 1.0), value) for name, value in self.model.coefficients.items()}
        return pd.DataFrame.from_dict(rows, orient="index", columns=["factor", "value"]).rename_axis("coefficient")


def factor_at(law: DepthLaw, configuration: Configuration, depth: float) -> float:
    """Return the factor of a coefficient relative to deep water at a depth [1]."""
    values = {**configuration.values(), "depth": depth}
    return float(law.factor(*[values[word] for word in argument_names(law.factor)]))


@accept_aliases
def at_depth(model: Model, depth: float) -> DepthCorrected:
    """Correct a model for another depth by Kijima's formulas.

    Tests of unknown depth count as deep. Tests at the depth itself are better: the formulas correct some of the hull's
    coefficients and none of the bank.

    Parameters
    ----------
    model : Model
        Model for one depth.
    depth : float [m]
        New depth.

    Raises
    ------
    InputError
        If no water is left under the keel.

    Examples
    --------
    >>> shallower = nw.at_depth(kcs, 15.0)
    >>> shallower.model.canal.depth
    15.0
    """
    old = model.configuration
    if not depth > old.ship.draft:
        raise InputError(f"a depth of {depth} m leaves no water under a draft of {old.ship.draft} m; raise it")
    was = old.canal.depth or DEEP
    factors = {
        term.name: factor_at(term.depth_law, old, depth) / factor_at(term.depth_law, old, was)
        for term in model.terms.terms
        if term.depth_law
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
    return DepthCorrected(moved, factors, _notes(model, factors, depth))


def _notes(model: Model, factors: Mapping[str, float], depth: float) -> tuple[str, ...]:
    kept = [term.name for term in (*model.terms.sway, *model.terms.yaw) if term.name not in factors]
    notes = [f"Not corrected: {', '.join(kept)}."] * bool(kept)
    unverified = [term.name for term in model.terms.terms if term.depth_law and not term.depth_law.verified]
    if unverified:
        notes.append(f"The exponent for {', '.join(unverified)} is from memory, not verified.")
    if model.configuration.canal.depth is None:
        notes.append("The depth of the tests is unknown; they count as deep water.")
    deeper = [term.name for term in model.terms.terms if term.needs_depth]
    if deeper:
        notes.append(f"The terms of {', '.join(deeper)} depend on depth: tests at one depth do not determine them.")
    ratio = depth / model.configuration.ship.draft
    if ratio < SHALLOWEST:
        notes.append(
            f"h/T = {ratio:.2f} is below {SHALLOWEST}, where the factors grow without limit and none was measured."
        )
    if any(factor < 1 for factor in factors.values()) and depth < (model.configuration.canal.depth or DEEP):
        notes.append("A factor below 1 in shallower water is outside the range of the corrections.")
    return tuple(notes)
