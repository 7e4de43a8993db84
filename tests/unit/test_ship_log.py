"""Records of a ship in memory: what they hold, what is refused, and a table that says the same."""

import numpy as np
import pytest

import narrows as nw


def record(name: str = "A", **signals: nw.Signal) -> nw.ShipRecord:
    t = np.arange(5.0)
    return nw.ShipRecord(name, {"x": nw.Signal(t, 4.0 * t), "y": nw.Signal(t[::2], np.zeros(3)), **signals})


def test_a_signal_is_joined_over_small_gaps_only() -> None:
    signal = nw.Signal(np.array([0.0, 1.0, 5.0]), np.array([0.0, 2.0, 10.0]))
    assert signal.at(np.array([-1.0, 0.5, 3.0, 5.0])).tolist() == pytest.approx([np.nan, 1.0, 6.0, 10.0], nan_ok=True)
    assert np.isnan(signal.at(np.array([3.0]), longest=2.0)).all()
    assert signal.at(np.array([1.0, 5.0]), longest=2.0).tolist() == [2.0, 10.0]


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda: nw.Signal(np.arange(3.0), np.arange(2.0)), "3 times and 2 values"),
        (lambda: nw.Signal(np.arange(2.0), np.array([1.0, np.nan])), "not finite"),
        (lambda: nw.ShipRecord("A", {"ruder": nw.Signal(np.zeros(1), np.zeros(1))}), "did you mean 'rudder'"),
        (lambda: nw.ShipRecord("A", {"x": np.zeros(1)}), "give nw.Signal"),
        (lambda: nw.ShipRecord("A", {}, antenna=(1.0,)), "give both"),
        (lambda: record()["psi"], "no signal 'psi'"),
        (lambda: nw.ShipLog((record("A"), record("A"))), "two records are called 'A'"),
        (lambda: nw.ShipLog((record("A"),))["B"], "no record 'B'"),
        (lambda: nw.ShipLog((record("A"),))[1], "no record 1"),
    ],
)
def test_what_is_wrong_is_said(make: object, told: str) -> None:
    with pytest.raises(nw.InputError, match=told):
        make()


def test_a_log_counts_and_shows_itself() -> None:
    log = nw.ShipLog((record("A"), record("B"), record("C")))
    assert [own.name for own in log] == ["A", "B", "C"]
    assert log.counts == {"x": 15, "y": 9}
    assert log.summary() == "3 records, 0.2 min together, with x, y."
    assert log[-1] is log["C"]
    assert log["A"].between(1.0, 3.0).start == 1.0


def test_its_table_has_a_row_for_each_time_and_says_what_was_not_measured() -> None:
    rows = nw.ShipLog((record("A"), record("B"))).to_dataframe()
    assert rows.columns.tolist() == ["record", "t", "x", "y"]
    assert len(rows) == 10
    assert rows["y"].isna().sum() == 4


def test_it_is_drawn() -> None:
    """A panel for each signal, in degrees where it is an angle, a line for each record that has it."""
    log = nw.ShipLog((record("A"), nw.ShipRecord("B", {"psi": nw.Signal(np.array([9.0, 10.0]), np.full(2, np.pi))})))
    panels = {axes.get_ylabel(): axes.lines for axes in log.plot().axes}
    assert {name: len(lines) for name, lines in panels.items()} == {"x [m]": 1, "y [m]": 1, "psi [deg]": 1}
    (line,) = panels["psi [deg]"]
    assert line.get_xydata().tolist() == [[0.0, pytest.approx(180.0)], [1.0, pytest.approx(180.0)]]
    assert nw.ShipLog((nw.ShipRecord("A", {}),)).plot().axes
    long = nw.Signal(np.arange(100_000.0), np.zeros(100_000))
    (line,) = nw.ShipLog((nw.ShipRecord("A", {"x": long}),)).plot().axes[0].lines
    assert 3000 < len(line.get_xdata()) <= 4000


def test_signals_and_records_by_hand() -> None:
    signal = nw.Signal(np.array([0.0, 1.0, 3.0, 4.0]), np.array([0.0, 2.0, 4.0, 10.0]))
    assert signal.step == 1.0
    assert nw.Signal(np.zeros(1), np.zeros(1)).step == np.inf
    assert signal.between(1.0, 3.0).values.tolist() == [2.0, 4.0]
    gaps = signal.at(np.array([0.5, 2.0, 3.5, 4.0, 4.5]), longest=1.5)
    assert gaps.tolist() == pytest.approx([1.0, np.nan, 7.0, 10.0, np.nan], nan_ok=True)
    assert np.isnan(nw.Signal(np.zeros(0), np.zeros(0)).at(np.zeros(2))).all()
    one = nw.ShipRecord("A", {"x": signal, "y": nw.Signal(np.array([2.0, 9.0]), np.zeros(2))})
    assert (one.start, one.stop, one.duration) == (0.0, 9.0, 9.0)
    assert np.isnan(nw.ShipRecord("A", {}).duration)
    log = nw.ShipLog((one, nw.ShipRecord("B", {"x": nw.Signal(np.array([0.0, 3591.0]), np.zeros(2))})))
    assert log.summary() == "2 records, 1 h together, with x, y."
    assert log[-2] is one
    with pytest.raises(nw.InputError, match="no record -3: they count from 0 to 1"):
        log[-3]
    table = nw.ShipRecord("A", {"x": nw.Signal(np.array([1.0, 0.0, 1.0]), np.array([5.0, 4.0, 6.0]))}).to_dataframe()
    assert table["x"].to_dict() == {0.0: 4.0, 1.0: 5.0}
