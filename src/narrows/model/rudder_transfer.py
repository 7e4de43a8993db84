"""A rudder for a hull that was tested without one: that of another, whose coefficients go with any size."""

from dataclasses import replace

import numpy as np

from narrows.errors import InputError
from narrows.model.model import Model
from narrows.terms.tables import HELM, with_helm

NAMES = tuple(term.name for terms in HELM.values() for term in terms)


def borrow_rudder(model: Model, lender: Model) -> Model:
    """Return a model with the rudder of another (ours).

    The coefficients of a rudder are over the area L T/100 and the length, so they hold for a hull with as large a
    rudder for her size, behind a propeller as loaded. What is known of their errors goes along where the model's own
    are known.

    Parameters
    ----------
    model : Model
        Without a rudder.
    lender : Model
        With the terms ``a_helm``, ``b_helm`` and ``c_helm``.

    Raises
    ------
    InputError
        Where the model has a rudder, or the lender has none.
    """
    if set(NAMES) & set(model.terms.names):
        raise InputError("the model has a rudder of its own; leave the other out")
    if not set(NAMES) <= set(lender.terms.names):
        raise InputError(f"the lender has no {', '.join(NAMES)}; identify it with the terms steered")
    terms = with_helm(model.terms)
    ship = replace(model.configuration.ship, flow_straightening=lender.configuration.ship.flow_straightening)
    return replace(
        model,
        configuration=replace(model.configuration, ship=ship),
        terms=terms,
        coefficients={**model.coefficients, **{name: lender.coefficients[name] for name in NAMES}},
        covariance=_joined(model, lender, terms.names),
        source=replace(model.source, text=f"{model.source.text}; rudder of {lender.configuration.ship.name}"),
    )


def _joined(model: Model, lender: Model, names: tuple[str, ...]) -> np.ndarray | None:
    """Both covariances, the two models' errors independent; None unless both are known."""
    if model.covariance is None or lender.covariance is None:
        return None
    joined = np.zeros((len(names), len(names)))
    for own, covariance, wanted in (
        (model.terms.names, model.covariance, model.terms.names),
        (lender.terms.names, lender.covariance, NAMES),
    ):
        place, there = [names.index(name) for name in wanted], [own.index(name) for name in wanted]
        joined[np.ix_(place, place)] = covariance[np.ix_(there, there)]
    return joined
