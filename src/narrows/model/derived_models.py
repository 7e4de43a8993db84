"""Models derived from another: at another depth, with another ship's rudder, with a transverse thrust."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from narrows.base.aliases import accept_aliases
from narrows.base.errors import InputError
from narrows.base.named_values import Coefficients
from narrows.model import additions
from narrows.model.froude import DerivedModel
from narrows.model.model import Model
from narrows.model.term import DepthLaw, TermKind, TermTable
from narrows.quantities.names import evaluate
from narrows.ship.particulars import Configuration

# h/T below which the corrections contradict measurements: the drift force by half, for the KCS at 1.2.
SHALLOWEST = 1.5
DEEP = 1e9  # A depth [m] at which every factor is 1


class DepthCorrected(DerivedModel):
    """A model corrected for another depth.

    >>> sorted(nw.at_depth(kcs, 15.0).factors)[:1]
    ['N_r']
    """

    @property
    def factors(self) -> dict[str, float]:
        """Factors of the corrected coefficients [1]."""
        return _factors(self.original, self.model.configuration.canal.depth or DEEP)

    def summary(self) -> str:
        configuration = self.model.configuration
        grown = ", ".join(f"{name} times {factor:.3g}" for name, factor in self.factors.items())
        ratio = (configuration.canal.depth or DEEP) / configuration.ship.draft
        return f"Taken to h/T = {ratio:.3g}: {grown or 'nothing was corrected'}."


def _factors(model: Model, depth: float) -> dict[str, float]:
    old, was = model.configuration, model.configuration.canal.depth or DEEP
    laws = {term.name: term.depth_law for term in model.terms.terms if term.depth_law}
    return {name: factor_at(law, old, depth) / factor_at(law, old, was) for name, law in laws.items()}


def factor_at(law: DepthLaw, configuration: Configuration, depth: float) -> float:
    """Return the factor of a coefficient relative to deep water at a depth [1]."""
    return float(evaluate(law.factor, {**configuration.values(), "depth": depth}))


@accept_aliases
def at_depth(model: Model, depth: float) -> DepthCorrected:
    """Correct a model for another depth by Kijima's formulas.

    Tests of unknown depth count as deep. Tests at the depth itself are better: the formulas correct some of the hull's
    coefficients and none of the bank.

    Raises an InputError if no water is left under the keel.

    Parameters
    ----------
    model : Model
        Model for one depth.
    depth : float [m]
        New depth.

    Examples
    --------
    >>> shallower = nw.at_depth(kcs, 15.0)
    >>> shallower.model.canal.depth
    15.0
    """
    old = model.configuration
    if not depth > old.ship.draft:
        raise InputError(f"a depth of {depth} m leaves no water under a draft of {old.ship.draft} m; raise it")
    factors = _factors(model, depth)
    grown = np.array([factors.get(name, 1.0) for name in model.terms.names])
    moved = replace(
        model,
        configuration=replace(old, canal=replace(old.canal, depth=depth)),
        coefficients=Coefficients({name: value * factors.get(name, 1.0) for name, value in model.coefficients.items()}),
        covariance=None if model.covariance is None else model.covariance * np.outer(grown, grown),
        data_range=replace(model.data_range, depth_to_draft=None),
        source=replace(model.source, text=f"{model.source.text}; taken to h/T = {depth / old.ship.draft:.2f} (Kijima)"),
    )
    return DepthCorrected(moved, model, _notes(model, factors, depth))


def _notes(model: Model, factors: Mapping[str, float], depth: float) -> tuple[str, ...]:
    kept = [term.name for term in (*model.terms.sway, *model.terms.yaw) if term.name not in factors]
    unverified = [term.name for term in model.terms.terms if term.depth_law and not term.depth_law.verified]
    deeper = [term.name for term in model.terms.terms if term.needs_depth]
    was, ratio = model.configuration.canal.depth, depth / model.configuration.ship.draft
    found = (
        (kept, f"Not corrected: {', '.join(kept)}."),
        (unverified, f"The exponent for {', '.join(unverified)} is from memory, not verified."),
        (was is None, "The depth of the tests is unknown; they count as deep water."),
        (deeper, f"The terms of {', '.join(deeper)} depend on depth: tests at one depth do not determine them."),
        (ratio < SHALLOWEST, f"h/T = {ratio:.2f} is below {SHALLOWEST}, where the factors grow without limit and none "
         "was measured."),
        (min(factors.values(), default=1.0) < 1 and depth < (was or DEEP),
         "A factor below 1 in shallower water is outside the range of the corrections."),
    )  # fmt: skip
    return tuple(note for applies, note in found if applies)


def extend(
    model: Model, terms: TermTable, coefficients: Mapping[str, float], covariance: np.ndarray | None = None
) -> Model:
    """Return a model with more terms; their errors are independent of the others, and zero unless given."""
    old, new = list(model.terms.names), list(coefficients)
    whole = None
    if model.covariance is not None:
        whole = np.zeros((len(terms), len(terms)))
        for names, part in ((old, model.covariance), (new, 0.0 if covariance is None else covariance)):
            places = [terms.names.index(name) for name in names]
            whole[np.ix_(places, places)] = part
    values = {**model.coefficients, **coefficients}
    return replace(
        model, terms=terms, coefficients=Coefficients({name: values[name] for name in terms.names}), covariance=whole
    )


@accept_aliases
def borrow_rudder(model: Model, lender: Model) -> Model:
    """Return a model with the rudder of another ship.

    The coefficients of a rudder are relative to the area L T/100 and the length. So they hold for a hull with the same
    relative rudder area and the same propeller loading. Their covariance is added if both models have one.

    Raises an InputError if the model has a rudder, or the lender has none.

    Parameters
    ----------
    model : Model
        A model without a rudder.
    lender : Model
        A model with the terms of ``steered``: ``a_helm``, ``b_helm`` and ``c_helm``.
    """
    if any(term.kind == TermKind.RUDDER for term in model.terms.terms):
        raise InputError("the model already has a rudder; leave the other out")
    names = dict(zip(*(additions.HELM.names(one.terms) for one in (model, lender)), strict=True))
    if not set(names.values()) <= set(lender.terms.names):
        raise InputError(
            f"the lender has no {', '.join(names.values())}; give a model fitted with --terms steered, or take a ship "
            "that has a rudder and banks, such as estimated_kcs (narrows ships lists all)"
        )
    ship = replace(model.configuration.ship, flow_straightening=lender.configuration.ship.flow_straightening)
    places = [lender.terms.names.index(lent) for lent in names.values()]
    known = None if lender.covariance is None else lender.covariance[np.ix_(places, places)]
    steered = extend(
        model if known is not None else replace(model, covariance=None),
        additions.HELM(model.terms), {name: lender.coefficients[lent] for name, lent in names.items()}, known,
    )  # fmt: skip
    return replace(
        steered,
        configuration=replace(model.configuration, ship=ship),
        source=replace(model.source, text=f"{model.source.text}; rudder of {lender.configuration.ship.name}"),
    )


@accept_aliases
def with_transverse_thrust(model: Model, share: float = 1.0) -> Model:
    """Return a model whose propeller pushes the stern sideways when it turns astern.

    A right-handed propeller pushes the stern to port, so that the bow turns to starboard. The force is that of the Esso
    Osaka (coefficients A_1 to A_5, B_1 to B_5 of Osaka University's MMG model), relative to L d (n D)^2.

    Raises an InputError if the model has no propeller, or has these terms.

    Parameters
    ----------
    model : Model
        A model with terms of a propeller.
    share : float [1]
        Force relative to the Esso Osaka's; negative for a left-handed propeller.

    Examples
    --------
    >>> tanker = nw.with_transverse_thrust(nw.published("yasukawa2015_kvlcc2_full"))
    >>> nw.crash_stop(tanker, revolutions=-1.0).side_reach > 100
    True
    """
    if not model.terms.propelled:
        raise InputError("the model has no propeller, which could push sideways")
    added = additions.TRANSVERSE_THRUST
    return extend(model, added(model.terms), dict.fromkeys(added.names(model.terms), float(share)))
