"""Revolutions of a propeller that keep a speed straight ahead."""

from dataclasses import replace
from typing import Any

import numpy as np

from narrows.aliases import accept_aliases
from narrows.errors import InputError
from narrows.model.model import Model
from narrows.ship.actuators import PROPELLER
from narrows.ship.motion import Motion
from narrows.simulation.settings import OWN_REVOLUTIONS
from narrows.simulation.steering import Steering


@accept_aliases
def self_propulsion(model: Model, u: float) -> float:
    """Return the revolutions at which thrust balances resistance straight ahead, rudder amidships [1/s].

    Parameters
    ----------
    model : Model
        A model with terms of a propeller.
    u : float [m/s]
        Surge velocity.

    Raises
    ------
    InputError
        If the model has no propeller, or no revolutions reach the speed.

    Examples
    --------
    >>> kvlcc2 = nw.published("yasukawa2015_kvlcc2")
    >>> round(float(nw.self_propulsion(kvlcc2, u=1.0)), 1)
    10.1
    """
    from scipy.optimize import brentq

    if not model.terms.propelled:
        raise InputError("this model has no terms of a propeller; there are no revolutions to look for")

    def surplus(revolutions: float) -> float:
        return -model.resistance(u, revolutions=revolutions)

    turns = 2.0 ** np.arange(-10, 20)
    fast = turns[np.asarray(model.forces(Motion.at(u=u), revolutions=turns)["X"]) > 0]
    if not len(fast):
        raise InputError(f"no revolutions drive this ship at {u:g} m/s; check the propeller and the resistance")
    return float(brentq(surplus, 0.0, float(fast[0]))) if surplus(0.0) < 0 else 0.0


def steady_ahead(model: Model, u: float) -> tuple[Model, str]:
    """The model with revolutions that keep the approach speed, and a note; itself if its own do, or nearly."""
    propeller, steady = model.configuration.propeller, steady_revolutions(model, u)
    if steady is None or propeller is None or not model.surge_inertia > 0:
        return model, ""
    configuration = replace(model.configuration, propeller=replace(propeller, revolutions=steady))
    own = f"the model's own, {propeller.revolutions:.3g}, are for another"
    note = f"{steady:.3g} revolutions a second keep the approach speed; {own}"
    return replace(model, configuration=configuration), note


def steady_revolutions(model: Model, u: float) -> float | None:
    """Return the revolutions that keep a speed straight ahead, if the model's own are for another speed [1/s]."""
    own = model.configuration.propeller.revolutions if model.configuration.propeller else 0.0
    if not (model.terms.propelled and own > 0 and u > 0):
        return None
    least, most = (model.resistance(u, revolutions=own / (1 + side * OWN_REVOLUTIONS)) for side in (1, -1))
    return None if least >= 0 >= most else self_propulsion(model, u)


def propeller_notes(model: Model, speeds: Any, turns: Any, steering: Steering | None) -> tuple[str, ...]:
    """Note that the model's own revolutions are for another speed [m/s]; none where others are given or ordered."""
    own = model.configuration.propeller
    ordered = steering is not None and any(one.name == PROPELLER.name for one in steering.law.ordered)
    if own is None or ordered or (turns is not None and np.any(np.asarray(turns) != own.revolutions)):
        return ()
    pairs = [(u, steady_revolutions(model, u)) for u in dict.fromkeys((float(np.min(speeds)), float(np.max(speeds))))]
    said = [f"{steady:.3g} keep {u:.3g} m/s straight ahead" for u, steady in pairs if steady is not None]
    if not said:
        return ()
    first = f"The propeller's {own.revolutions:.3g} revolutions a second are for another speed"
    return (f"{first}: {', '.join(said)} (--revolutions, in Python revolutions=).",)
