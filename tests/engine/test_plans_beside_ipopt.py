"""The first rate of a plan is that of IPOPT on the same problem, free, at the limits of the gear, and by a bank."""

import numpy as np
import pytest
from plans import converged, ipopt_rates, orders

pytest.importorskip("daqp")
casadi = pytest.importorskip("casadi")
STATES = {
    "free": (0.75, 0.01, 0.0, 0.0, 0.02),
    "far off": (-1.6, 0.0, 0.0, 0.0, 0.0),
    "off its course": (0.2, 0.08, -0.02, 0.01, 0.05),
    "by the bank": (2.0, 0.04, 0.0, 0.0, 0.0),
}


@pytest.mark.slow
@pytest.mark.parametrize("state", STATES.values(), ids=STATES)
def test_the_first_rate_is_that_of_ipopt(state: tuple[float, ...]) -> None:
    plan, rates = converged(np.array(state), 25), ipopt_rates(casadi, np.array(state))
    fastest = orders().planner.limits[1]
    assert plan.rates[0] == pytest.approx(rates[0], rel=0.01, abs=1e-4 * fastest)
