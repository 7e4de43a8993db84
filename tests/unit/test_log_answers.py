"""Judgements of a learned log on both sides of their limits, and errors of predictions by hand and by simulation."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from narrows.logbook.learned_coefficients import LearnedCoefficient
from narrows.logbook.learning.log_fit import Gusts, LogFit, RecordAnswer, SignalNoise, nomoto_errors, rms_of

DEGREE = math.pi / 180


def coefficient(name: str, value: float = 1.0, std: float = 0.1, from_bank: bool = False) -> LearnedCoefficient:
    return LearnedCoefficient(name, "1", 1.0, 0.3, value, std, from_bank)


def record(missed: tuple[float, float], whole: tuple[float, ...] = (), duration: float = 60.0) -> RecordAnswer:
    names = ("before", "after", "nomoto")
    errors = {"y": (math.nan, math.nan), "psi": missed, "r": (0.1, 0.2)}
    return RecordAnswer("A", duration, {}, {}, errors, dict(zip(names, whole, strict=False)))


def fit(**changed: object) -> LogFit:
    usual = LogFit(
        model=None, prior=SimpleNamespace(has_bank=True),
        coefficients={"c_bank": coefficient("c_bank", from_bank=True)},
        records=(record((0.3, 0.1)), record((0.4, 0.2))), gusts=None, noise={"psi": SignalNoise(0.4 * DEGREE, 0.0)},
        disagreement=3.0, freedom=2, probability=0.5, about=(), converged=True,
    )  # fmt: skip
    return replace(usual, **changed)


@pytest.mark.parametrize(
    ("changed", "doubt"),
    [
        ({}, ""), ({"probability": 0.0011}, ""), ({"probability": 0.0009}, "contradict each other"),
        ({"converged": False}, "did not converge"), ({"gusts": Gusts(0.1, 0.1, 9.0, 0.0, 7.9)}, ""),
        ({"gusts": Gusts(0.1, 0.1, 9.0, 0.0, 8.1)}, "8 times as strong"),
        ({"noise": {"psi": SignalNoise(0.49 * DEGREE, 0.0)}}, ""),
        ({"noise": {"psi": SignalNoise(0.51 * DEGREE, 0.0)}}, "misses the heading by 0.5 deg"), ({"noise": {}}, ""),
        ({"records": (record((1, 1), (0.3, 0.2, 0.25)), record((1, 1), (0.3, 0.1, 0.2)))}, ""),
        ({"records": (record((1, 1), (0.3, 0.2, 0.15)), record((1, 1), (0.3, 0.1, 0.05)))}, "nonlinear Nomoto"),
    ],
)  # fmt: skip
def test_a_doubt_is_said_beyond_its_limit(changed: dict[str, object], doubt: str) -> None:
    """A thousandth of probability, 8 times the gusts, half a degree of heading, a simpler model's error."""
    notes = fit(**changed).notes[:-2]
    assert len(notes) == bool(doubt)
    assert not doubt or doubt in notes[0]


def test_a_contradiction_names_what_moved_by_more_than_three_deviations() -> None:
    known = {name: coefficient(name, value) for name, value in (("a", 1.89), ("b", 1.91), ("c", 0.09))}
    (first, *_) = fit(coefficients=known, probability=0.0).notes
    assert "mainly in b, c:" in first


def test_a_log_informs_where_it_learned_a_coefficient_of_the_bank() -> None:
    """Or any coefficient, where the model has no bank."""
    other = {"c_bank": coefficient("c_bank", std=0.2, from_bank=True), "b_v": coefficient("b_v")}
    assert fit().informative
    assert not fit(coefficients=other).informative
    assert fit(coefficients=other, prior=SimpleNamespace(has_bank=False)).informative


def test_errors_of_records_are_joined_as_root_mean_squares() -> None:
    """sqrt((0.09 + 0.16) / 2) and sqrt((0.01 + 0.04) / 2); a record without an error counts in neither."""
    known = fit(records=(record((0.3, 0.1)), record((0.4, 0.2)), record((math.nan, 0.9))))
    assert known.forecast_rmse("psi") == pytest.approx((math.sqrt(0.125), math.sqrt(0.025)))
    assert np.isnan(known.forecast_rmse("y")).all()
    whole = fit(records=(record((1, 1), (0.3, 0.1, 0.5)), record((1, 1), (0.4, 0.2, 0.7)), record((1, 1))))
    expected = {"before": math.sqrt(0.125), "after": math.sqrt(0.025), "nomoto": math.sqrt(0.37)}
    assert whole.whole_missed == pytest.approx(expected)
    assert fit(records=(record((1, 1), (0.3, 0.1, 0.5)),)).whole_missed == {}
    assert "does not improve" not in fit().summary()
    assert "does not improve" in fit(records=(record((0.1, 0.1)), record((0.1, 0.1)))).summary()


def test_errors_of_forecasts_are_root_mean_squares_of_offset_heading_and_yaw_rate() -> None:
    errors = np.array([[0, 3, 0.1, 0, 0, 0.01], [0, -4, 0.3, 0, 0, -0.02]])
    assert rms_of(errors) == pytest.approx({"y": math.sqrt(12.5), "psi": math.sqrt(0.05), "r": math.sqrt(0.00025)})
    assert np.isnan(list(rms_of(np.zeros((0, 6))).values())).all()


def steered(turn: float, damping: float, seed: int, error: float = 0.0) -> SimpleNamespace:
    """A zigzag of rdot = a rudder - c r - d |r| r, in steps of a hundredth of those of the record."""
    step, fine, times = 1.0, 0.01, np.arange(0.0, 121.0)
    rudder = 0.3 * np.sign(np.sin(2 * math.pi * (times + 7 * seed) / (30.0 + 4 * seed)))
    psi, r, heading = 0.2, 0.0, []
    for angle in rudder:
        heading.append(psi)
        for _ in range(round(step / fine)):
            psi += fine * r
            r += fine * (turn * angle - damping * r - 2.0 * abs(r) * r)
    read = SimpleNamespace(values=np.array(heading) + error * np.random.default_rng(seed).standard_normal(len(heading)))
    return SimpleNamespace(
        step=step, times=times, positions={"rudder": rudder}, readings={"psi": read}, times_of=lambda one: times
    )


def test_a_nomoto_model_of_the_other_records_predicts_one_of_the_same_ship() -> None:
    """To a quarter of a degree of swings of 20 degrees; with noise, to that noise; one of another ship far worse."""
    same = nomoto_errors([steered(0.02, 0.1, seed) for seed in range(3)], 10.0)
    assert max(same) < 0.25 * DEGREE
    noisy = nomoto_errors([steered(0.02, 0.1, seed, 0.01) for seed in range(3)], 10.0)
    assert noisy == pytest.approx([0.01] * 3, rel=0.25)
    mixed = nomoto_errors([*(steered(0.02, 0.1, seed) for seed in range(2)), steered(0.04, 0.2, 2)], 10.0)
    assert mixed[2] > 1.0 * DEGREE
    assert nomoto_errors([steered(0.02, 0.1, 1)], 10.0)[0] < 0.25 * DEGREE
    blind = steered(0.02, 0.1, 1)
    blind.readings = {}
    assert np.isnan(nomoto_errors([blind], 10.0)).all()
