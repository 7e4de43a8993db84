"""What a run would tell: the information matrix of its columns, before it is made."""

from collections.abc import Mapping

import numpy as np

from narrows.captive.runs import Run
from narrows.captive.synthetic import NOISE, motion_of
from narrows.errors import InputError
from narrows.identification.regression.problem import slots
from narrows.ship.particulars import Configuration
from narrows.terms.term import TermTable

RATE = 5.0
"""Of sampling [Hz]; what a run tells depends on its noise per time, not on how often it is sampled."""


def run_information(
    run: Run,
    configuration: Configuration,
    terms: TermTable,
    noise: Mapping[str, float] = NOISE,
    correlation_time: float = 0.5,
) -> np.ndarray:
    """Return the information matrix (p, p) that one run adds, a row for each parameter (ours).

    Parameters
    ----------
    run : Run
        The run.
    configuration : Configuration
        Ship, canal and water.
    terms : TermTable
        The terms; tied coefficients are one parameter.
    noise : mapping of str to float [N, N, N m]
        Standard deviation of each force.
    correlation_time : float [s]
        Of the noise: 2 of these hold one independent row.

    Raises
    ------
    InputError
        Where a term needs a particular that the ship file does not give.
    """
    columns = run.columns(RATE)
    depth = {} if run.depth is None else {"depth": run.depth}
    values = {**configuration.values(), **motion_of(columns).values(), **depth}
    for name in terms.inputs:
        if name not in values:
            raise InputError(f"the terms need {name}, which the ship file does not give; add it")
    slot = slots(terms)
    information = np.zeros((max(slot.values()) + 1,) * 2)
    rows_of_its_own = 1 / max(1.0, 2 * correlation_time * RATE)
    for force, part in terms.forces.items():
        if not part:
            continue
        design = np.array([np.broadcast_to(term.column(values), len(columns["t"])) for term in part])
        products = design @ design.T * rows_of_its_own / noise[force] ** 2
        index = [slot[term.name] for term in part]
        np.add.at(information, np.ix_(index, index), products)
    return information
