"""A steady wind in envelopes: its course is that of ``steady_course`` under the force, and gusts come on top."""

from functools import cache

import numpy as np
import pytest

import narrows as nw
from narrows.safety.trials import trials

pytestmark = pytest.mark.usefixtures("one_tuning")

SPEEDS = np.array([3.0, 5.0])
FORCE = nw.wind_force(10.0, 4000.0)


@cache
def kcs() -> nw.Model:
    return nw.published("estimated_kcs")


def enveloped(**forces: float) -> nw.SafeEnvelope:
    calm = nw.Disturbance(0.0, gust_lever=-10.0, **forces)
    return nw.safe_envelope(kcs(), np.array([0.0, 20.0]), SPEEDS, samples=4, disturbance=calm)


def test_the_reserve_is_asked_with_the_wind_on() -> None:
    """Of the most likely ship by another function; the wind comes from either side, and the larger rudder counts."""
    found = enveloped(steady=FORCE).data
    heave = [nw.squat(kcs().configuration, u).sinkage for u in SPEEDS]
    for u, down in zip(SPEEDS, heave, strict=True):
        sides = [
            nw.steady_course(kcs(), y=[0.0, 20.0], u=u, heave=down, Y=side * FORCE, N=-10.0 * side * FORCE)["rudder"]
            for side in (1, -1)
        ]
        np.testing.assert_allclose(abs(found["rudder_likely"].sel(u=u)), np.max(np.abs(sides), axis=0), rtol=1e-9)
    middle = found["rudder_95"].sel(y=0.0)
    assert (middle > enveloped().data["rudder_95"].sel(y=0.0) + np.radians(2.0)).all()
    assert (found["rudder_95"] == enveloped(steady=FORCE, gust=FORCE).data["rudder_95"]).all()


def test_a_ship_holds_its_course_in_the_wind_that_it_began_in() -> None:
    """Of the ship that the pilot is made for, with nothing off at the start: it does not leave its line."""
    certain = nw.Model(kcs().configuration, kcs().terms, kcs().coefficients)
    windy = nw.Disturbance(0.0, steady=FORCE, gust_lever=-10.0)
    tried = trials(certain, np.array([0.0]), SPEEDS, np.zeros(2), windy, 4, 0)
    found = np.abs(tried["rudder"]) <= np.radians(35.0)
    assert found.any()
    assert (tried["held"] == found).all()
    assert len(np.unique(np.sign(tried["rudder"].sel(u=SPEEDS[-1])))) == 2
    gusty = nw.Disturbance(0.0, steady=FORCE, gust=3 * FORCE, gust_lever=-10.0, gust_time=300.0)
    thrown = trials(certain, np.array([0.0]), SPEEDS, np.zeros(2), gusty, 4, 0)
    assert not thrown["held"].equals(tried["held"])
