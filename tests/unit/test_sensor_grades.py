"""Grades of sensors: each signal with its errors, the better grade the smaller errors."""

import math
from itertools import pairwise

import pytest

from narrows.base.errors import InputError
from narrows.logbook.ship_log import GRADES, SensorGrade, SignalGrade, sensor_grade


@pytest.mark.parametrize("grade", GRADES.values(), ids=GRADES)
def test_every_grade_has_the_place_and_the_heading(grade: SensorGrade) -> None:
    assert {"y", "psi"} <= set(grade.signals)
    assert grade.name in grade.summary()


def test_a_better_grade_errs_less() -> None:
    for better, worse in pairwise(GRADES.values()):
        for name in set(better.signals) & set(worse.signals):
            assert better.signals[name].noise <= worse.signals[name].noise
            assert better.signals[name].zero <= worse.signals[name].zero


def test_a_grade_is_found_by_name_or_is_ones_own() -> None:
    own = SensorGrade("own", "a test's", {"y": SignalGrade(0.1)})
    assert sensor_grade("vdr") is GRADES["vdr"]
    assert sensor_grade(own) is own
    with pytest.raises(InputError, match="choose rtk or vdr or ais"):
        sensor_grade("radar")
    with pytest.raises(InputError, match="no signal 'yaw'"):
        SensorGrade("own", "", {"yaw": SignalGrade(0.1)})
    with pytest.raises(InputError, match="noise = 0"):
        SignalGrade(0)


DEGREE, KNOT = math.pi / 180, 1852 / 3600
# Noise, period [s], wander, its memory [s], zero: metres, degrees, degrees a second, metres a second.
WRITTEN_OUT = {
    "rtk": {
        "y": (0.05, 1, 0, 60, 0.3), "x": (0.05, 1, 0, 60, 0.3), "psi": (0.05, 1, 0, 60, 0.1),
        "r": (0.008, 1, 0.002, 60, 0), "v_ground": (0.02, 1, 0.01, 100, 0), "u_ground": (0.02, 1, 0.01, 100, 0),
        "rudder": (0.1, 1, 0, 60, 0.3),
    },
    "vdr": {
        "y": (0.7, 1, 1, 300, 2), "x": (0.7, 1, 1, 300, 2), "psi": (0.15, 1, 0.2, 600, 0.5),
        "r": (0.01, 1, 0.004, 60, 0), "u": (0.1, 1, 0, 60, 0.1), "rudder": (0.4, 1, 0, 60, 0.5),
    },
    "ais": {
        "y": (1.5, 10, 1, 300, 3), "x": (1.5, 10, 1, 300, 3), "psi": (0.3, 10, 0.2, 600, 1),
        "speed_over_ground": (0.05 * KNOT, 10, 0.05 * KNOT, 300, 0),
    },
}  # fmt: skip


@pytest.mark.parametrize("name", WRITTEN_OUT)
def test_sensors_that_a_forecast_assumes(name: str) -> None:
    """Written out: a change here changes what a record is said to determine.

    IMO A.424: a gyro's settled error is to 1 degree under way, of which half is a standard deviation. AIS rounds
    headings to whole degrees, an error of 1 / sqrt(12) degrees.
    """
    grade = sensor_grade(name)
    assert set(grade.signals) == set(WRITTEN_OUT[name])
    for signal, (noise, period, wander, memory, zero) in WRITTEN_OUT[name].items():
        unit, own = DEGREE if signal in ("psi", "r", "rudder") else 1.0, grade.signals[signal]
        found = (own.noise / unit, own.period, own.wander / unit, own.memory, own.zero / unit)
        assert found == pytest.approx((noise, period, wander, memory, zero)), signal
    assert sensor_grade("ais").signals["psi"].noise == pytest.approx(DEGREE / math.sqrt(12), rel=0.05)
    assert sensor_grade("vdr").signals["psi"].zero == pytest.approx(1.0 * DEGREE / 2)


def test_a_grade_of_few_words_has_a_reading_a_second_and_no_other_error() -> None:
    usual = SignalGrade(0.1)
    assert (usual.period, usual.wander, usual.memory, usual.zero) == (1.0, 0.0, 60.0, 0.0)
