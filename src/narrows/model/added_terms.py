"""Terms added to a model: the rudder of another ship, the transverse thrust of a propeller that turns astern."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from narrows.aliases import accept_aliases
from narrows.errors import InputError
from narrows.model.model import Model
from narrows.terms import additions
from narrows.terms.term import TermKind, TermTable


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
    return replace(model, terms=terms, coefficients={name: values[name] for name in terms.names}, covariance=whole)


@accept_aliases
def borrow_rudder(model: Model, lender: Model) -> Model:
    """Return a model with the rudder of another ship.

    The coefficients of a rudder are relative to the area L T/100 and the length. So they hold for a hull with the same
    relative rudder area and the same propeller loading. Their covariance is added if both models have one.

    Parameters
    ----------
    model : Model
        A model without a rudder.
    lender : Model
        A model with the terms of ``steered``: ``a_helm``, ``b_helm`` and ``c_helm``.

    Raises
    ------
    InputError
        If the model has a rudder, or the lender has none.
    """
    if any(term.kind == TermKind.RUDDER for term in model.terms.terms):
        raise InputError("the model already has a rudder; leave the other out")
    names = dict(zip(_helm(model.terms), _helm(lender.terms), strict=True))
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
        additions.with_helm(model.terms), {name: lender.coefficients[lent] for name, lent in names.items()}, known,
    )  # fmt: skip
    return replace(
        steered,
        configuration=replace(model.configuration, ship=ship),
        source=replace(model.source, text=f"{model.source.text}; rudder of {lender.configuration.ship.name}"),
    )


def _helm(terms: TermTable) -> list[str]:
    """Names of a rudder's terms in a table."""
    return [term.name for helm in additions.helm_terms(terms).values() for term in helm]


@accept_aliases
def with_transverse_thrust(model: Model, share: float = 1.0) -> Model:
    """Return a model whose propeller pushes the stern sideways when it turns astern.

    A right-handed propeller pushes the stern to port, so that the bow turns to starboard. The force is that of the Esso
    Osaka, relative to L d (n D)^2.

    Parameters
    ----------
    model : Model
        A model with terms of a propeller.
    share : float [1]
        Force relative to the Esso Osaka's; negative for a left-handed propeller.

    Raises
    ------
    InputError
        If the model has no propeller, or has these terms.

    References
    ----------
    Coefficients A_1 to A_5 and B_1 to B_5 of the MMG model of the Esso Osaka (3 m model) at Osaka University.

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
