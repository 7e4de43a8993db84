"""A plan of steady legs keeps to its limits, and tells beforehand what the legs then teach."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import narrows as nw
from engine_models import steered
from narrows.logbook.steady_legs import allowed_legs, usual_offsets, usual_speeds
from narrows.quantities.names import KNOT

CALM = nw.SteadyConditions(
    wind=0.5, y_zero=0.01, yaw_rate_deg=0.02, sway_change=0.001,
    y_error=0.02, u_error=0.01, rudder_error_deg=0.5, drift_error_deg=0.1,
)  # fmt: skip


@cache
def ship(bank: float = 0.03) -> nw.Model:
    model = steered().with_coefficients(b_bank=0.3, c_bank=0.04)
    values = np.array([model.coefficients[name] for name in model.terms.names])
    std = np.array(
        [bank if term.name == "c_bank" else 0.05 * value for term, value in zip(model.terms.terms, values, strict=True)]
    )
    known = replace(model, covariance=np.diag(std**2), data_range=nw.DataRange(speed=(0.5, 1.0), abs_y=(0.0, 1.0)))
    return replace(known, configuration=replace(known.configuration, canal=nw.Canal(7.0, 0.4)))


@cache
def plan(**told) -> nw.SteadyPlan:
    return nw.plan_steady(ship(), conditions=CALM, **told)


def test_legs_come_in_pairs_and_each_side_begins_in_turn() -> None:
    legs = plan(legs=6).legs
    assert len({(abs(leg["offset"]), leg["speed"]) for leg in legs}) == 1
    for number, (first, other) in enumerate(zip(legs[::2], legs[1::2], strict=True)):
        assert first["offset"] == -other["offset"]
        assert (first["offset"] > 0) == (number % 2 == 0)
        assert [leg["side"] == "starboard" for leg in (first, other)] == [number % 2 == 0, number % 2 == 1]
        for angle in ("rudder", "drift"):
            assert first[f"{angle}_low"] == pytest.approx(-other[f"{angle}_high"])
            assert first[f"{angle}_low"] < first[f"{angle}_median"] < first[f"{angle}_high"]


def test_every_leg_leaves_rudder_side_and_keel() -> None:
    found = plan()
    limit, canal = found.most_rudder, ship().configuration.canal
    for leg in found.legs:
        course = nw.steady_course(ship(), y=leg["offset"], u=KNOT * leg["speed"], samples=2000, seed=9)
        assert np.mean(np.abs(course["rudder"]) <= limit) >= 0.93
        assert canal.width / 2 - abs(leg["offset"]) >= ship().configuration.ship.beam
        assert KNOT * leg["speed"] < nw.choke_speed(ship().configuration)


def test_a_leg_keeps_half_a_beam_between_the_bank_and_the_nearest_corner() -> None:
    """Half the width, 3.5 m, less a beam of 0.572 m, and less what the drift turns half the length out."""
    known = 1e-12 * np.eye(len(ship().terms.names))
    straight, drifting = (replace(ship().with_coefficients(b_bank=b, c_bank=0.0), covariance=known) for b in (0, 0.01))
    assert [*allowed_legs(straight, np.array([2.90, 2.92, 2.94]), np.array([0.5]))[0][0]] == [2.90, 2.92]
    (allowed, _, _, drift), notes = allowed_legs(drifting, np.arange(2.5, 3.0, 0.002), np.array([0.5]))
    turned = ship().configuration.ship.length / 2 * np.sin(np.abs(drift[-1, 1]))
    assert not any("rudder" in note for note in notes)
    assert turned > 0.02
    assert 0.0 <= 3.5 - 0.572 - allowed[-1] - turned < 0.003


def test_what_it_tells_is_what_the_legs_teach() -> None:
    """Legs that read as the most likely coefficients have it."""
    found = plan()
    assert found.std["c_bank"][-1] < 0.5 * found.std["c_bank"][0]
    assert np.all(np.diff(found.std["c_bank"]) <= 0)
    y, u = (size * found.to_dataframe()[name].to_numpy() for name, size in (("offset", 1.0), ("speed", KNOT)))
    heave = np.array([nw.squat(ship().configuration, speed).sinkage for speed in u])
    held = [nw.steady_course(ship(), y=a, u=b, heave=c) for a, b, c in zip(y, u, heave, strict=True)]
    read = {"y": y, "u": u, "rudder": [float(c["rudder"]) for c in held], "drift": [float(c["psi"]) for c in held]}
    learned = nw.learn_steady(ship(), read, conditions=CALM)
    for name in found.std:
        assert found.std[name][-1] == pytest.approx(learned.std[name], rel=1e-3)


def test_a_plan_is_no_worse_than_as_many_legs_elsewhere() -> None:
    best = plan(targets="c_bank")
    for offset, speed in ((0.2, 0.5), (0.4, 0.55)):
        other = nw.plan_steady(ship(), [offset], [speed], conditions=CALM, targets="c_bank")
        assert other.legs
        assert other.std["c_bank"][-1] >= best.std["c_bank"][-1]


def test_where_no_leg_is_allowed_there_is_none_and_the_answer_says_why() -> None:
    found = nw.plan_steady(ship(bank=3.0), conditions=CALM)
    assert found.legs == ()
    assert "No leg off the middle is allowed" in found.summary()
    assert "not allowed for the rudder" in " ".join(found.notes)


def test_offsets_and_speeds_are_round_and_within_the_canal() -> None:
    offsets, speeds = usual_offsets(ship()), usual_speeds(ship())
    assert offsets[-1] <= 3.5 - 2 * 0.286
    assert np.allclose(offsets / offsets[0], np.arange(1, len(offsets) + 1))
    assert speeds.min() >= 0.45
    assert speeds.max() <= 1.05


@pytest.mark.parametrize(
    ("told", "said"),
    [
        ({"legs": 3}, "even number"),
        ({"legs": 0}, "whole number"),
        ({"offsets": [0.0]}, "over 0"),
        ({"targets": ("d_bank",)}, "unknown coefficient 'd_bank'"),
    ],
)
def test_a_plan_that_cannot_be_is_refused_in_a_sentence(told: dict, said: str) -> None:
    with pytest.raises(nw.InputError, match=said):
        nw.plan_steady(ship(), **told)
