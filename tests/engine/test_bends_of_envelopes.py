"""An envelope in a bend: its rudder is that of the steady turn, its shares those of ships that sail the bend."""

from functools import cache

import numpy as np
import pytest

import narrows as nw
from narrows.safety.request import Bend
from narrows.safety.trials import trials
from narrows.waterway import Bank, Centreline, Waterway

pytestmark = pytest.mark.usefixtures("one_tuning")

RADIUS, SAMPLES, SPEED = 1500.0, 60, 4.0
OFFSETS = (0.0, 22.5)
# A bend of three ship lengths; 10 m to starboard no rudder holds the most likely ship.
TIGHT, MANY, NEAR = 700.0, 400, (-10.0, 0.0)


@cache
def kcs() -> nw.Model:
    return nw.published("estimated_kcs")


@cache
def arc(radius: float = RADIUS) -> Waterway:
    """A bend to starboard as wide and deep as the canal of the ship."""
    angle = np.linspace(0.0, min(3.5 * RADIUS / radius, 6.2), 351)  # No second round
    line = Centreline(radius * np.stack([1 - np.cos(angle), np.sin(angle)], axis=1))
    s, half = np.array([0.0, line.length]), np.full(2, kcs().configuration.canal.width / 2)
    depth = np.full(2, kcs().configuration.canal.depth)
    return Waterway(line, Bank("starboard", s, half), Bank("port", s, half), (s, depth))


@cache
def enveloped(curvature: float) -> nw.SafeEnvelope:
    """For the rudder of the most likely ship, which has no samples."""
    return nw.safe_envelope(
        kcs(), np.array(OFFSETS), np.array([SPEED]), samples=2, curvature=curvature, walls=(150.0, 150.0)
    )


def test_the_rudder_of_an_envelope_is_that_of_the_steady_turn() -> None:
    """As ``linearize`` finds it on the line of a waterway, of the most likely ship with its squat."""
    heave = nw.squat(kcs().configuration, SPEED).sinkage
    place = {"waterway": arc(), "at": arc().line.length / 2, "heave": heave}
    bend = [nw.control.linearize(kcs(), y, SPEED, **place).course["rudder"] for y in OFFSETS]
    likely = enveloped(1 / RADIUS).data["rudder_likely"].to_numpy().ravel()
    np.testing.assert_allclose(likely, bend, rtol=1e-3)
    straight = enveloped(0.0).data["rudder_likely"].to_numpy().ravel()
    assert (np.abs(likely) > np.abs(straight) + np.radians(8.0)).all()


def test_the_other_way_is_the_mirror() -> None:
    one = enveloped(1 / RADIUS).data.sel(y=0.0)
    other = enveloped(-1 / RADIUS).data.sel(y=0.0)
    np.testing.assert_allclose(one["rudder_likely"], -other["rudder_likely"], rtol=1e-9)


@pytest.mark.parametrize(("radius", "samples", "offsets"), [(RADIUS, SAMPLES, OFFSETS), (TIGHT, MANY, NEAR)])
def test_shares_are_those_of_ships_that_sail_the_bend(radius: float, samples: int, offsets: tuple[float, ...]) -> None:
    """The same drawn ships along an arc on a map, under the regulator that is made for it; heading off alike."""
    psi = nw.Disturbance().drawn(samples, 0)["psi"]
    turns_of_propeller = nw.self_propulsion(kcs(), SPEED)  # As in trials, and not those of the service speed
    length, beam = kcs().configuration.ship.length, kcs().configuration.ship.beam
    tried = trials(
        kcs(), np.array(offsets), np.array([SPEED]), np.zeros(1), nw.Disturbance(), samples, 0, bend=Bend(1 / radius),
        knowing=False,
    )  # fmt: skip
    for y in offsets:
        pilot = nw.control.regulator(kcs(), y, SPEED, waterway=arc(radius), at=arc(radius).line.length / 2)
        line, turn = pilot.lines[0], SPEED / (radius - y)
        ended = nw.ensemble(
            kcs(), samples=samples, x=2 * length, y=y, u=SPEED, psi=line.psi + line.turning[0] * turn + psi, r=turn,
            v=line.v + line.turning[1] * turn, rudder=line.rudder + line.turning[2] * turn, waterway=arc(radius),
            controller=pilot, revolutions=turns_of_propeller, duration=15 * length / SPEED, bottom=False,
        )  # fmt: skip
        there = tried.sel(y=y).isel(u=0)
        turns = (np.abs(there["rudder"]) <= np.radians(35.0)).to_numpy()  # Others have no course to begin from.
        back = ((ended["outcome"] == 0) & (np.abs(ended["y_end"] - y) < beam / 2)).to_numpy().ravel()
        share, sailed = there["held"].to_numpy()[turns].mean(), back[turns].mean()
        print(y, sailed, share, turns.mean(), back[~turns].mean())
        assert share == pytest.approx(sailed, abs=2 * (0.8 * 0.2 / turns.sum()) ** 0.5)
        # Most ships without a steady course leave the line within 15 lengths.
        assert radius != TIGHT or back[~turns].mean() < 0.5


def test_a_limit_in_a_bend_is_that_of_nineteen_samples_in_twenty() -> None:
    """Not that of the most likely ship, which keeps its reserve in the bend at any speed."""
    place, speeds = arc().line.length / 2, np.array([SPEED])
    along = nw.envelope_along(kcs(), arc(), [place], y=[0.0], u=speeds, samples=SAMPLES)
    assert np.isnan(along.to_dataframe()["highest_speed"]).all()
    likely = float(enveloped(1 / RADIUS).data["rudder_likely"].sel(y=0.0).item())
    assert abs(likely) < 2 / 3 * np.radians(35.0)
