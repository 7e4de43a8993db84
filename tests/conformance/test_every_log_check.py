"""Every check of a record finds a fault and leaves good records alone; every kind of fault has an example."""

from collections.abc import Callable, Iterator

import numpy as np
import pytest

import narrows as nw
from faults import FAULTS as EXAMPLES
from faults import ashore, scaled
from logs import bend, bent_waterway, circle, kvlcc2, zigzag
from narrows.logbook.checking import check_log
from narrows.logbook.checking.check_log import RECORD_CHECKS, Checked, Finding
from narrows.logbook.checking.faults import FAULTS, MISREADINGS, Misreading
from narrows.logbook.ship_log import SIGNALS


def checked(record: nw.ShipRecord, waterway: nw.Waterway | None = None, speed: float = 7.0) -> Checked:
    return Checked(record, kvlcc2(), waterway, kvlcc2().ship.length / speed)


def spoiled() -> list[Checked]:
    seldom = zigzag().with_signals(rudder=nw.Signal(zigzag()["rudder"].t[::20], zigzag()["rudder"].values[::20]))
    others = [
        checked(scaled(100.0, "u")(zigzag()), speed=700.0),  # Centimetres
        checked(seldom),
        checked(ashore(bend()), bent_waterway(length=9000.0)),
    ]
    cut = zigzag().with_signals(
        x=nw.Signal(np.delete(zigzag()["x"].t, slice(300, 400)), np.delete(zigzag()["x"].values, slice(300, 400)))
    )
    return [*others, checked(cut), *(checked(spoil(zigzag())) for spoil, *_ in EXAMPLES.values())]


@pytest.mark.parametrize("check", RECORD_CHECKS, ids=lambda check: check.__name__)
def test_a_check_finds_a_fault_and_leaves_good_records_alone(
    check: Callable[[Checked], Iterator[Finding]], monkeypatch: pytest.MonkeyPatch
) -> None:
    """And ``check_log`` asks it."""
    monkeypatch.setattr(check_log, "_by_filter", lambda *asked: ())
    found = [(at, {one.check for one in check(at)}) for at in spoiled()]
    assert any(
        named and named <= {one.check for one in nw.check_log(nw.ShipLog((at.record,), at.waterway), kvlcc2()).findings}
        for at, named in found
    )
    good = [checked(zigzag()), checked(circle()), checked(bend(), bent_waterway(length=9000.0))]
    assert [one for at in good for one in check(at)] == []
    few = nw.ShipRecord("few", {name: zigzag()[name] for name in ("x", "y")})
    assert all(isinstance(one, Finding) for one in check(checked(few)))


@pytest.mark.parametrize("other", MISREADINGS, ids=lambda other: other.sentence)
def test_a_misreading_names_signals_and_changes_them(other: Misreading) -> None:
    assert set(other.signals) <= set(SIGNALS)
    full = zigzag().with_signals(v=zigzag()["v_ground"])
    again = other.reread(full)
    assert any(not np.array_equal(again[name].values, full[name].values) for name in other.signals)


def test_every_kind_of_fault_has_an_example() -> None:
    checks = {check for _, check, _ in EXAMPLES.values()}
    for kind in FAULTS:
        assert any(check.endswith(kind) for check in checks), kind
