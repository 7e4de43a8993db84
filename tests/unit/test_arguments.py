"""Arguments of simulation: what is no number, no time, no step, no count is refused in one sentence."""

import math
import time
from fractions import Fraction

import numpy as np
import pytest

import narrows as nw
from narrows.base.errors import shown

DTC, KVLCC2 = nw.published("mikkelsen2025_dtc"), nw.published("yasukawa2015_kvlcc2")
NO_NUMBERS = {
    "complex": 1j, "complex array": np.array(1 + 1j), "nan": math.nan, "inf": math.inf, "a word": "0.5",
    "nothing": None, "true": True, "a list": [0.1], "400 digits": 10**400, "4300 digits": 10**4300,
    "more": -(10**5000), "a dict": {}, "beyond all measure": 1e308,
    "a date": np.datetime64("2020-01-01"), "an object": object(),
}  # fmt: skip


def sentence(act) -> str:
    start = time.perf_counter()
    with pytest.raises(nw.InputError) as error:
        act()
    assert time.perf_counter() - start < 5.0
    assert "\n" not in str(error.value)
    assert len(str(error.value)) < 400
    return str(error.value)


@pytest.mark.parametrize("value", NO_NUMBERS.values(), ids=NO_NUMBERS)
@pytest.mark.parametrize("name", ["y", "u", "x", "psi", "v", "r", "rudder", "duration", "dt", "X", "N", "at"])
def test_no_number(name: str, value: object) -> None:
    if name in ("u", "duration", "dt") and value is None:
        return  # what suits the ship
    given = [1.0, value] if name == "at" else value
    assert name in sentence(lambda: nw.simulate(DTC, **{name: given}))


@pytest.mark.parametrize("value", [0.0, -1.0])
@pytest.mark.parametrize("name", ["duration", "dt"])
@pytest.mark.parametrize("act", [nw.simulate, nw.ensemble])
def test_no_time(act, name: str, value: float) -> None:
    assert "must be a positive" in sentence(lambda: act(DTC, **{name: value}))


@pytest.mark.parametrize("act", [nw.simulate, nw.ensemble])
@pytest.mark.parametrize(
    "times", [{"dt": 1e-300}, {"dt": 5e-324}, {"dt": 1e-9}, {"duration": 1e11}, {"duration": 1e19, "dt": 1e-300}]
)
def test_too_many_steps_are_refused_at_once(act, times: dict[str, float]) -> None:
    said = sentence(lambda: act(DTC, **times))
    assert "steps" in said
    assert "lengthen dt or shorten the duration" in said


def test_a_voyage_keeps_its_steps_and_an_ensemble_does_not() -> None:
    """What a voyage cannot keep an ensemble may take."""
    assert "6e+07 steps" in sentence(lambda: nw.simulate(DTC, dt=1e-6))
    assert nw.ensemble(DTC, y=3.21, v=1.0, dt=1e-6)["time"] < 0.01


@pytest.mark.parametrize("workers", [0, -1, 1.5, True, "2", 10**9, math.nan, 10**5000], ids=shown)
def test_workers(workers: object) -> None:
    assert "give a whole number from 1" in sentence(lambda: nw.ensemble(DTC, workers=workers, duration=1.0))


def test_more_voyages_than_memory() -> None:
    many = np.linspace(-1.0, 1.0, 100_000)
    assert "run parts" in sentence(lambda: nw.ensemble(DTC, y=many, u=many + 2.0))


def test_a_start_without_finite_forces() -> None:
    """The hull's forces of the MMG method are over the speed."""
    assert "not finite at u = 0" in sentence(lambda: nw.simulate(KVLCC2, u=0.0, contact="none"))


@pytest.mark.parametrize("name", ["b_vv", "c_vv", "c_rr", "b_bank"])
@pytest.mark.parametrize("value", [-1e300, 1e300])
def test_a_voyage_that_runs_out_of_numbers_has_an_end(name: str, value: float) -> None:
    away = DTC.with_coefficients(**{name: value})
    assert nw.simulate(away, 0.5, v=0.1, r=0.01, duration=5.0).outcome.kind in ("diverged", "grounded", "left validity")


@pytest.mark.parametrize("value", [1, np.int64(1), np.float32(1.0), np.array(1.0), Fraction(1)])
def test_every_kind_of_real_number_is_one(value) -> None:
    assert nw.simulate(DTC, 0.5, value, duration=value).outcome == nw.simulate(DTC, 0.5, 1.0, duration=1.0).outcome
