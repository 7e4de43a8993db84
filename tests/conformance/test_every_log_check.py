"""Every check of ``CHECKS``: it finds a fault that a record may have, and leaves good records alone."""

from collections.abc import Iterator
from functools import cache

import pytest

import narrows as nw
from faults import FAULTS, ashore
from logs import bend, bent_waterway, circle, kvlcc2, zigzag
from narrows.logbook.checking.agreement import even_motion
from narrows.logbook.checking.check_log import CHECKS
from narrows.logbook.checking.finding import Examined, Finding, LogCheck

every_check = pytest.mark.parametrize("own", CHECKS, ids=lambda own: own.check.__name__)


def examined(record: nw.ShipRecord, waterway: nw.Waterway | None = None) -> Examined:
    motion = even_motion(record, kvlcc2().configuration.ship.length, waterway)
    assert motion is not None
    return Examined(record, motion, kvlcc2(), waterway)


@cache
def way() -> nw.Waterway:
    return bent_waterway(length=9000.0)


def spoiled(own: LogCheck) -> Iterator[Examined]:
    """Its own example, or else every record with a fault that the tests know."""
    if own.example is not None:
        yield examined(own.example(zigzag()))
        return
    yield from (examined(spoil(zigzag())) for spoil, *_ in FAULTS.values())
    yield examined(ashore(bend()), way())


def found_by(own: LogCheck) -> list[Finding]:
    """What it finds in the first record in which it finds anything wrong."""
    for record in spoiled(own):
        if found := [one for one in own.check(record) if one.wrong]:
            return found
    return []


@every_check
def test_it_finds_a_fault_and_says_what_to_do(own: LogCheck) -> None:
    found = found_by(own)
    assert found, "no fault of tests/faults.py is found by it, and it has no example"
    for one in found:
        assert one.check
        assert one.sentence
        assert one.remedy


@every_check
def test_good_records_are_left_alone(own: LogCheck) -> None:
    good = [examined(zigzag()), examined(zigzag(-10.0, 1)), examined(circle()), examined(bend(), way())]
    assert [one for record in good for one in own.check(record)] == []


@every_check
def test_a_record_that_has_hardly_a_signal_is_passed_over(own: LogCheck) -> None:
    """Whatever is missing is for the check of what is missing to say; no other stumbles over it."""
    record = zigzag()
    for kept in ({"x", "y"}, {"x", "y", "psi"}, {"u", "rudder"}, {"x", "y", "r"}):
        signals = {name: record[name] for name in record if name in kept}
        assert all(isinstance(one, Finding) for one in own.check(examined(nw.ShipRecord("few", signals))))


def test_each_check_is_there_once() -> None:
    names = [own.check.__name__ for own in CHECKS]
    assert len(set(names)) == len(names)
