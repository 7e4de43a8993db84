"""A rudder for a hull tested without one: that of another ship, whose coefficients do not depend on size."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from narrows.aliases import accept_aliases
from narrows.errors import InputError
from narrows.model.model import Model
from narrows.terms.additions import helm_terms, with_helm
from narrows.terms.term import TermKind, TermTable


@accept_aliases
def borrow_rudder(model: Model, lender: Model) -> Model:
    """Return a model with the rudder of another ship.

    The coefficients of a rudder are relative to the area L T/100 and the length. So they hold for a hull with the same
    relative rudder area and the same propeller loading. Their covariance is added if the model has one.

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
    if _rudder(model.terms):
        raise InputError("the model already has a rudder; leave the other out")
    names = dict(zip(_helm(model.terms), _helm(lender.terms), strict=True))
    if not set(names.values()) <= set(lender.terms.names):
        raise InputError(
            f"the lender has no {', '.join(names.values())}; give a model fitted with --terms steered, or take a ship "
            "that has a rudder and banks, such as estimated_kcs (narrows ships lists all)"
        )
    terms = with_helm(model.terms)
    ship = replace(model.configuration.ship, flow_straightening=lender.configuration.ship.flow_straightening)
    return replace(
        model,
        configuration=replace(model.configuration, ship=ship),
        terms=terms,
        coefficients={**model.coefficients, **{name: lender.coefficients[lent] for name, lent in names.items()}},
        covariance=_joined(model, lender, terms.names, names),
        source=replace(model.source, text=f"{model.source.text}; rudder of {lender.configuration.ship.name}"),
    )


def _rudder(terms: TermTable) -> list[str]:
    return [term.name for term in terms.terms if term.kind == TermKind.RUDDER]


def _helm(terms: TermTable) -> list[str]:
    """Names of a rudder's terms in a table."""
    return [term.name for helm in helm_terms(terms).values() for term in helm]


def _joined(model: Model, lender: Model, names: tuple[str, ...], lent: Mapping[str, str]) -> np.ndarray | None:
    """Both covariances, with independent errors; None unless both are known."""
    if model.covariance is None or lender.covariance is None:
        return None
    joined = np.zeros((len(names), len(names)))
    for source_names, covariance, wanted in (
        (model.terms.names, model.covariance, {name: name for name in model.terms.names}),
        (lender.terms.names, lender.covariance, lent),
    ):
        rows, there = [names.index(name) for name in wanted], [source_names.index(name) for name in wanted.values()]
        joined[np.ix_(rows, rows)] = covariance[np.ix_(there, there)]
    return joined
