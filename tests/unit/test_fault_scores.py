"""Score tests of a sensor's faults against dense algebra, and what mends and rereads a record, by hand."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

import narrows as nw
from narrows.logbook.checking import faults
from narrows.logbook.checking.faults import (
    MISREADINGS,
    Fault,
    FaultTest,
    FaultTests,
    Misreading,
    faults_of,
    longest_run,
)
from narrows.logbook.filtering.record_grid import Readings, RecordGrid

DEGREE, KNOT = math.pi / 180, 1852 / 3600


def fault_tests(records: int, scatter: float = 1.0, tries: int = 1) -> FaultTests:
    """Three fitted numbers, of which two are coefficients, and two faults; scores as their information expects."""
    draw, parts, scores = np.random.default_rng(4), [], []
    for _ in range(records):
        root = draw.normal(size=(5, 9))
        parts.append(root @ root.T)
        scores.append(scatter * root @ draw.normal(size=9))
    precision = np.diag([1.0, 2.0, 0.5])
    problem = SimpleNamespace(precision=precision, count=2, prior=SimpleNamespace(precision=precision[:2, :2]))
    unknowns = np.array([0.2, -0.1, 0.3])
    found = SimpleNamespace(problem=problem, unknowns=unknowns, scaled=unknowns[:2])
    faults = tuple((Fault("zero", name, None, 1.0, tries), "A") for name in ("psi", "r"))
    return FaultTests(found, faults, tuple(parts), np.array(scores))


@pytest.mark.parametrize("known", [(), (4,)])
def test_a_size_is_the_efficient_score_over_its_information(known: tuple[int, ...]) -> None:
    """The last number of a joint step of Fisher scoring with the prior, and its standard error."""
    tests = fault_tests(3, tries=2)
    whole = sum(tests.parts) + np.diag([1.0, 2.0, 0.5, 0.0, 0.0])
    score = tests.scores.sum(axis=0) - np.array([0.2, -0.2, 0.15, 0.0, 0.0])
    found = tests.tested(known)
    assert [test.place for test in found] == [place for place in (3, 4) if place not in known]
    for test in found:
        joint = [0, 1, 2, *known, test.place]
        inverse = np.linalg.inv(whole[np.ix_(joint, joint)])
        assert test.size == pytest.approx(float((inverse @ score[joint])[-1]))
        assert test.error == pytest.approx(math.sqrt(inverse[-1, -1]))
        assert test.significance == pytest.approx(test.size / test.error)
        assert test.probability == pytest.approx(min(1.0, 2 * 2 * stats.norm.sf(abs(test.significance))))


@pytest.mark.parametrize(("records", "scatter", "is_wider"), [(3, 20.0, False), (4, 20.0, True), (6, 0.3, False)])
def test_scores_that_scatter_more_than_expected_make_errors_wider(records: int, scatter: float, is_wider: bool) -> None:
    """From four records on: White's variance by the records' own scores at the fault, and Student's t."""
    tests = fault_tests(records, scatter)
    whole = sum(tests.parts) + np.diag([1.0, 2.0, 0.5, 0.0, 0.0])
    for test in tests.tested():
        joint = [0, 1, 2, test.place]
        inverse = np.linalg.inv(whole[np.ix_(joint, joint)])
        direction = np.zeros(5)
        direction[joint] = inverse[-1] / inverse[-1, -1]
        own = [
            one @ direction - test.size * direction @ part @ direction
            for one, part in zip(tests.scores, tests.parts, strict=True)
        ]
        wide = math.sqrt(records / (records - 1) * np.sum(np.square(own))) * inverse[-1, -1]
        narrow = math.sqrt(inverse[-1, -1])
        assert (wide > narrow) == (scatter > 1)
        assert test.error == pytest.approx(wide if is_wider else narrow)
        tail = stats.t(records - 1) if is_wider else stats.norm()
        assert test.probability == pytest.approx(2 * float(tail.sf(abs(test.size / test.error))))


def test_what_the_fitted_numbers_explain_is_not_tested() -> None:
    """The second fault is the first number over again."""
    tests = fault_tests(3)
    copy = np.array([[1, 0, 0, 0, 0], [0, 1, 0, 0, 0], [0, 0, 1, 0, 0], [0, 0, 0, 1, 0], [1, 0, 0, 0, 0]], float)
    parts = tuple(copy @ (1e9 * part) @ copy.T for part in tests.parts)
    assert [test.place for test in FaultTests(tests.found, tests.faults, parts, tests.scores).tested()] == [3]


def test_a_mended_fault_moves_the_coefficients_as_a_refit_would() -> None:
    tests = fault_tests(3)
    whole = sum(tests.parts) + np.diag([1.0, 2.0, 0.5, 0.0, 0.0])
    (_, second) = tests.tested()
    shift, probability = tests.mended(second)
    moved = -np.linalg.solve(whole[:3, :3], whole[:3, 4] * second.size)
    size = np.sqrt(np.diag(np.linalg.inv(whole[:3, :3])))
    np.testing.assert_allclose(shift, (moved / size)[:2])
    after = np.array([0.2, -0.1]) + moved[:2]
    assert probability == pytest.approx(float(stats.chi2(2).sf(after[0] ** 2 + 2 * after[1] ** 2)))


def test_faults_of_one_kind_in_several_records_are_one_fault_of_all(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two records with a zero of psi each, one with a step: the last number is the zero of both."""
    draw = np.random.default_rng(0)
    zero, step = Fault("zero", "psi", None), Fault("step", "psi", None)
    own = {"A": [zero], "B": [zero, step]}
    pieces = {}
    for name, kinds in own.items():
        root = draw.normal(size=(1 + len(kinds), 4))
        pieces[name] = (name, kinds, draw.normal(size=1 + len(kinds)), root @ root.T)
    monkeypatch.setattr("narrows.logbook.checking.faults._of_record", lambda found, grid, record: pieces[grid])
    found = SimpleNamespace(unknowns=np.zeros(1), records=(None, None), problem=SimpleNamespace(precision=np.eye(1)))
    tests = FaultTests.of(found, ["A", "B"], "all")  # type: ignore[arg-type,list-item]
    assert tests.faults == ((zero, "A"), (zero, "B"), (step, "B"), (zero, "all"))
    (_, _, score, information), (_, _, other, more) = pieces.values()
    np.testing.assert_allclose(tests.scores, [[*score, 0, 0, score[1]], [other[0], 0, other[1], other[2], other[1]]])
    np.testing.assert_allclose(tests.parts[0][np.ix_([0, 1], [0, 1])], information)
    np.testing.assert_allclose(tests.parts[0][4, [0, 1, 2, 3, 4]], [*information[1], 0, 0, information[1, 1]])
    np.testing.assert_allclose(tests.parts[1][np.ix_([0, 2, 3], [0, 2, 3])], more)
    assert tests.information[0, 0] == pytest.approx(information[0, 0] + more[0, 0] + 1.0)


def grid() -> RecordGrid:
    """Five steps of 2 s: x and y in the middle of each, psi at a quarter, a rudder that rises."""
    steps, times = np.arange(5), 2.0 * np.arange(6)
    reads = {
        name: Readings(value + steps, steps, np.full(5, share), np.ones(5))
        for name, value, share in (("x", 100.0, 0.5), ("y", 3.0, 0.5), ("psi", 0.1, 0.25))
    }
    record = nw.ShipRecord("A", {}, antenna=(30.0, 2.0))
    return RecordGrid(record, times, np.ones(5, bool), {"rudder": 0.1 * times**2}, reads)


def test_a_zero_a_step_a_gain_and_a_delay_are_taken_out_of_readings() -> None:
    one = grid()
    zero = Fault("zero", "psi", one).mended(0.2)
    np.testing.assert_allclose(zero.readings["psi"].values, one.readings["psi"].values - 0.2)
    np.testing.assert_array_equal(zero.readings["y"].values, one.readings["y"].values)
    step = Fault("step", "y", one, at=5.0).mended(4.0)  # readings of y are at 1, 3, 5, 7 and 9 s
    np.testing.assert_allclose(step.readings["y"].values - one.readings["y"].values, [0, 0, -4, -4, -4])
    gain = Fault("gain", "psi", one).mended(0.25)
    assert gain.readings["psi"].gain == 0.75
    late = Fault("delay", "psi", one).mended(0.5)  # s, of a step of 2 s
    np.testing.assert_allclose(late.readings["psi"].share, 0.0)
    places = Fault("delay", "x", one).mended(0.5)
    np.testing.assert_allclose([places.readings[name].share for name in ("x", "y", "psi")], [[0.25] * 5] * 3)
    alone = Fault("delay", "y", one).mended(0.5)
    np.testing.assert_allclose([alone.readings[name].share[0] for name in ("x", "y")], [0.5, 0.25])


def test_an_antenna_moves_forward_and_a_rudder_is_corrected() -> None:
    one = grid()
    assert Fault("antenna", "x", one).mended(5.0).record.antenna == (35.0, 2.0)
    angle = one.positions["rudder"]
    corrected = {kind: Fault(kind, "rudder", one).mended(0.5).positions["rudder"] for kind in ("zero", "gain", "delay")}
    np.testing.assert_allclose(corrected["zero"], angle - 0.5)
    np.testing.assert_allclose(corrected["gain"], 1.5 * angle)
    np.testing.assert_allclose(corrected["delay"][1:-1], (angle + 0.5 * 0.2 * one.times)[1:-1])


def test_each_signal_has_the_faults_that_can_be_told() -> None:
    normalised = {
        "x": np.array([9.0, 1, 2, 1, 1]),
        "y": np.array([0.0, 1, -5, 1, 1]),
        "psi": np.array([0.0, 1, 2, 3, -4]),
    }
    found = list(faults_of(grid(), normalised))
    kinds = [(fault.kind, fault.signal) for fault in found]
    assert kinds == [
        ("step", "x"), ("zero", "y"), ("step", "y"), ("zero", "psi"), ("delay", "psi"), ("step", "psi"), ("delay", "x"),
        ("antenna", "x"), ("zero", "rudder"), ("gain", "rudder"), ("delay", "rudder"),
    ]  # fmt: skip
    steps = {fault.signal: fault for fault in found if fault.kind == "step"}
    assert {name: (fault.at, fault.tries) for name, fault in steps.items()} == {
        "x": (5.0, 5),
        "y": (5.0, 5),
        "psi": (8.5, 5),
    }
    scales = {(fault.kind, fault.signal): fault.scale for fault in found}
    assert scales["zero", "y"] == 0.1
    assert scales["zero", "psi"] == scales["zero", "rudder"] == pytest.approx(DEGREE)
    rates = Readings(np.zeros(2), np.arange(2), np.zeros(2), np.ones(2))
    turning = RecordGrid(grid().record, grid().times, grid().whole, {}, {"r": rates})
    assert [(fault.kind, fault.scale) for fault in faults_of(turning, {})] == [
        ("zero", pytest.approx(0.01 * DEGREE)), ("gain", 1.0), ("delay", 1.0),
    ]  # fmt: skip


def test_signals_are_reread_in_other_units_signs_and_axes() -> None:
    t = np.array([0.0, 1.0])
    record = nw.ShipRecord("A", {
        "rudder": nw.Signal(t, np.array([0.1, -0.3])), "psi": nw.Signal(t, np.array([0.0, math.pi / 2])),
        "u_ground": nw.Signal(t, np.array([3.0, 3.0])), "v_ground": nw.Signal(t, np.array([1.0, 1.0])),
    })  # fmt: skip
    assert Misreading(("rudder",), "", -1.0).reread(record)["rudder"].values.tolist() == [-0.1, 0.3]
    along_axes, along_ship = (one.reread(record) for one in MISREADINGS[-2:])
    # Along x and y: at a heading to starboard of 90 degrees the y axis is ahead, the x axis to port.
    np.testing.assert_allclose(along_axes["u_ground"].values, [3.0, 1.0], atol=1e-12)
    np.testing.assert_allclose(along_axes["v_ground"].values, [1.0, -3.0], atol=1e-12)
    np.testing.assert_allclose(along_ship["u_ground"].values, [3.0, -1.0], atol=1e-12)
    np.testing.assert_allclose(along_ship["v_ground"].values, [1.0, 3.0], atol=1e-12)
    assert not Misreading(("rudder",), "", DEGREE, least=1.2).possible(record)
    assert Misreading(("rudder",), "", DEGREE, least=0.3).possible(record)
    assert not Misreading(("r",), "").possible(record)


def test_factors_of_other_units_are_those_of_their_definitions() -> None:
    factors = {}
    for one in MISREADINGS:
        factors.setdefault(one.signals, []).append(one.factor)
    assert factors["rudder",] == pytest.approx([-1.0, DEGREE, 1 / DEGREE])
    assert factors["r",] == pytest.approx([-1.0, DEGREE, DEGREE / 60])
    assert factors["psi", "r"] == pytest.approx([DEGREE])
    assert factors["u",] == factors["u_ground", "v_ground"] == pytest.approx([KNOT])
    assert factors["revolutions",] == pytest.approx([1 / 60, 60.0])
    assert Misreading(("u",), "", KNOT).sentence == "u is 1.944 times what it should be"
    assert Misreading(("u",), "", -1.0).sentence == "u counts the other way"


def test_a_stuck_value_lasts_from_its_first_reading_to_its_last() -> None:
    assert longest_run(np.array([1.0, 2.0, 2.0, 2.0, 3.0, 3.0])) == [1, 3]
    assert longest_run(np.array([5.0, 5.0, 1.0])) == [0, 1]
    assert longest_run(np.array([1.0, 2.0, 7.0, 7.0])) == [2, 3]


def test_a_significance_is_a_size_over_its_error() -> None:
    assert FaultTest(3, None, "A", 4.0, 2.0, 0.05).significance == 2.0  # type: ignore[arg-type]


@pytest.mark.parametrize(("noise", "ratio"), [(0.3, 3.0), (0.05, 1.0)])
def test_noise_of_a_reread_signal_is_that_of_its_second_differences(
    noise: float, ratio: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a signal that rises evenly, over the noise of 0.1 that the model has, and no less than that."""
    tried: list[np.ndarray] = []
    follower = SimpleNamespace(smoothed=lambda unknowns, path, passes: tried.append(unknowns))
    monkeypatch.setattr(faults, "RecordLikelihood", lambda problem, grid: follower)
    t = np.arange(4000.0)
    values = 0.2 * t + noise * np.random.default_rng(0).standard_normal(len(t))
    told = SimpleNamespace(record=nw.ShipRecord("A", {"y": nw.Signal(t, values)}))
    model = SimpleNamespace(estimated=(SimpleNamespace(of="noise", names=("y",)),), noise={"y": 0.1})
    problem = SimpleNamespace(precision=np.eye(3), count=2, model=model)
    assert faults._fitted(problem, None, told) == (math.inf, 1.0)  # type: ignore[arg-type]
    np.testing.assert_allclose(np.exp(tried[0]), [1.0, 1.0, ratio], rtol=0.05)
