"""An envelope in a bend: its rudder is that of the steady turn, its shares those of ships that sail the bend."""

from functools import cache

import numpy as np
import pytest

import narrows as nw
from narrows.safety.held_trials import trials
from narrows.safety.request import Bend
from narrows.waterway import Bank, Centreline, Waterway

RADIUS, SAMPLES, SPEED = 1500.0, 60, 4.0
OFFSETS = (0.0, 22.5)


@cache
def kcs() -> nw.Model:
    return nw.published("estimated_kcs")


@cache
def arc() -> Waterway:
    """A bend to starboard as wide and deep as the canal of the ship."""
    angle = np.linspace(0.0, 3.5, 351)
    line = Centreline(RADIUS * np.stack([1 - np.cos(angle), np.sin(angle)], axis=1))
    s, half = np.array([0.0, line.length]), np.full(2, kcs().configuration.canal.width / 2)
    depth = np.full(2, kcs().configuration.canal.depth)
    return Waterway(line, Bank("starboard", s, half), Bank("port", s, half), (s, depth))


@cache
def enveloped(curvature: float) -> nw.SafeEnvelope:
    return nw.safe_envelope(
        kcs(), np.array(OFFSETS), np.array([SPEED]), samples=SAMPLES, curvature=curvature, walls=(150.0, 150.0)
    )


def test_the_rudder_of_an_envelope_is_that_of_the_steady_turn() -> None:
    """As ``linearize`` finds it on the line of a waterway, of the most likely ship with its squat."""
    heave = nw.squat(kcs().configuration, SPEED).sinkage
    bend = nw.control.linearize(
        kcs(), list(OFFSETS), SPEED, waterway=arc(), at=arc().line.length / 2, heave=heave
    )  # fmt: skip
    likely = enveloped(1 / RADIUS).data["rudder_likely"].to_numpy().ravel()
    np.testing.assert_allclose(likely, bend.course["rudder"].ravel(), rtol=1e-3)
    straight = enveloped(0.0).data["rudder_likely"].to_numpy().ravel()
    assert (np.abs(likely) > np.abs(straight) + np.radians(8.0)).all()


def test_the_other_way_is_the_mirror() -> None:
    one = enveloped(1 / RADIUS).data.sel(y=0.0)
    other = enveloped(-1 / RADIUS).data.sel(y=0.0)
    np.testing.assert_allclose(one["rudder_likely"], -other["rudder_likely"], rtol=1e-9)


def test_shares_are_those_of_ships_that_sail_the_bend() -> None:
    """The same drawn ships along an arc on a map, under the regulator that is made for it; heading off alike."""
    psi = nw.Disturbance().drawn(SAMPLES, 0)["psi"]
    length, beam = kcs().configuration.ship.length, kcs().configuration.ship.beam
    tried = trials(
        kcs(), np.array(OFFSETS), np.array([SPEED]), np.zeros(1), nw.Disturbance(), SAMPLES, 0, bend=Bend(1 / RADIUS),
        knowing=False,
    )  # fmt: skip
    for y in OFFSETS:
        pilot = nw.control.regulator(kcs(), y, SPEED, waterway=arc(), at=arc().line.length / 2)
        line, turn = pilot.lines[0], SPEED / (RADIUS - y)
        ended = nw.ensemble(
            kcs(), samples=SAMPLES, x=2 * length, y=y, u=SPEED, psi=line.psi + line.turning[0] * turn + psi, r=turn,
            v=line.v + line.turning[1] * turn, rudder=line.rudder + line.turning[2] * turn, waterway=arc(),
            controller=pilot, duration=15 * length / SPEED, bottom=False,
        )  # fmt: skip
        there = tried.sel(y=y).isel(u=0)
        turns = (np.abs(there["rudder"]) <= np.radians(35.0)).to_numpy()  # Others have no course to begin from.
        back = ((ended["outcome"] == 0) & (np.abs(ended["y_end"] - y) < beam / 2)).to_numpy().ravel()[turns]
        share = there["held"].to_numpy()[turns].mean()
        print(y, back.mean(), share, turns.mean())
        assert share == pytest.approx(back.mean(), abs=2 * (0.8 * 0.2 / turns.sum()) ** 0.5)


def test_a_limit_in_a_bend_is_that_of_nineteen_samples_in_twenty() -> None:
    """Not that of the most likely ship, which keeps its reserve in the bend at any speed."""
    place, speeds = arc().line.length / 2, np.array([SPEED])
    with pytest.raises(nw.InputError, match="no speed is safe"):
        nw.speed_limits(kcs(), arc(), [place], u=speeds, samples=SAMPLES)
    likely = float(enveloped(1 / RADIUS).data["rudder_likely"].sel(y=0.0).item())
    assert abs(likely) < 2 / 3 * np.radians(35.0)
