"""Grades of sensors: each signal with its errors, the better grade the smaller errors."""

from itertools import pairwise

import pytest

from narrows.base.errors import InputError
from narrows.logbook.sensor_grades import GRADES, SensorGrade, SignalGrade, sensor_grade


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
