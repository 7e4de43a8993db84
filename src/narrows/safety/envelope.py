"""The safe envelope: how fast, and how far off the middle of a canal, a ship is still in hand."""

from dataclasses import replace
from functools import partial

import numpy as np

from narrows.control.steady_course import check_rudder
from narrows.model.model import Model
from narrows.safety.answer import SafeEnvelope
from narrows.safety.bounds import bounds_of, rudder_of_a_kick
from narrows.safety.caveats import with_caveats
from narrows.safety.disturbance import Disturbance
from narrows.safety.held_trials import trials
from narrows.safety.pilot_choice import check_pilot, choose_pilot
from narrows.safety.question import Walls, envelope_question
from narrows.safety.shares import likely_shares, settled_trials, shares_of
from narrows.simulation.inputs import check_workers

# Of disturbances alone, that the ship of the most likely coefficients is tried in.
LIKELY_SAMPLES = 200
# Of the rudder, to be left when the ship is steady.
RESERVE = 1 / 3


def safe_envelope(
    model: Model, y: np.ndarray | None = None, u: np.ndarray | None = None, *,
    disturbance: Disturbance | None = None, reserve: float = RESERVE, keel: float | None = None,
    most_revolutions: float | None = None, samples: int | None = None, seed: int = 0, walls: Walls | None = None,
    bank: str = "steep", controller: str = "regulator", workers: int | None = None, progress: bool = False,
) -> SafeEnvelope:  # fmt: skip
    """Find how fast and how far off the middle a ship is still in hand.

    At each offset and speed the steady course is sought that holds it: rudder, heading and drift in balance. The ship
    is safe there where that course leaves a reserve of rudder, one pilot with the real gear, who does not know the
    coefficients, holds it against disturbances, the keel is clear and the canal is not choked. Beside that stands where
    a pilot who knows them would. Coefficients are drawn from the covariance of the fit.

    Parameters
    ----------
    model : Model
        Of the ship at its own size, with the terms of a rudder.
    y : array (offsets,) [m], optional
        To starboard of the middle; as far as half a beam from either bank unless given.
    u : array (speeds,) [m/s], optional
        Through the water; to a little over the speed that chokes the canal unless given.
    disturbance : Disturbance, optional
        What throws the ship off.
    reserve : float [1]
        Of the rudder, to be left on the steady course.
    keel : float [m], optional
        Least clearance under the keel; a twentieth of the draft unless given.
    most_revolutions : float [1/s], optional
        Of the engine, where the model has a propeller: faster than that it cannot go, and what a kick ahead with it
        saves of the rudder is told.
    samples : int, optional
        Of coefficients and disturbances; unless given as many as settle the edge to a step of the offsets and speeds.
    seed : int
        Of the samples.
    walls : pair of float [m], optional
        Where its keel meets the banks, to port and to starboard of the middle; the walls of the canal unless given.
    bank : str
        Kind of bank, for the rules from outside that the answer stands beside: ``gentle``, ``sloping`` or ``steep``.
    controller : str
        Who does not know the coefficients: ``regulator``, the best that is offered; ``track``, that of earlier
        versions; ``human``, a hand at the wheel with its delay, whole degrees and a cap.
    workers : int, optional
        Threads; all cores unless given.
    progress : bool
        Show a bar.

    Raises
    ------
    InputError
        Where the model has no rudder, nothing says how fast, a number is out of range, or a bank or pilot is unknown.
    """
    check_rudder(model)
    check_workers(workers)
    check_pilot(controller)
    question = envelope_question(model, y, u, disturbance, reserve, keel, most_revolutions, walls, bank, controller)
    bounds = bounds_of(question)
    try_more = partial(
        trials, y=question.offsets, u=question.speeds, heave=bounds.under.midship, disturbance=question.disturbance,
        walls=question.walls, chosen=choose_pilot(question, bounds, seed, workers), workers=workers, progress=progress,
    )  # fmt: skip
    tried = settled_trials(partial(try_more, model), samples, seed, question.rudder_limit, bounds.clear & bounds.tested)
    likely = tried
    if model.covariance is not None:
        likely = try_more(replace(model, covariance=None), samples=LIKELY_SAMPLES, seed=seed)
    data = shares_of(tried, question.rudder_limit).assign(bounds.columns())
    data = data.assign(likely_shares(likely, question.rudder_limit))
    if most_revolutions is not None:
        data = data.assign(rudder_kick=rudder_of_a_kick(question, bounds.under))
    data["y"].attrs, data["u"].attrs = {"units": "m"}, {"units": "m/s"}
    return with_caveats(SafeEnvelope(data), question, bounds.under, tried.sizes["sample"])
