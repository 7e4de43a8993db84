"""Learning from records: a ship whose truth is known is found again, what cannot be learned is said, no row is lost."""

import re
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

import narrows as nw
from logs import D, kvlcc2, sensed, trial, zigzag
from narrows.logbook.filtering.likelihood import RecordLikelihood
from narrows.logbook.filtering.record_grid import grid_of
from narrows.logbook.learning.learn_log import _source
from narrows.logbook.learning.log_fit import Gusts
from narrows.logbook.learning.log_setup import parts

WRONG = {"N_v": 1.12, "Y_v": 0.9, "N_rudder": 0.93, "R_0": 1.1}
MANOEUVRES = ("psi", "x", "y", "r", "rudder")


def mistaken() -> nw.Model:
    """The ship by coefficients that err within their spread."""
    return kvlcc2().with_coefficients(**{name: factor * kvlcc2()[name] for name, factor in WRONG.items()})


def of_manoeuvre(record: nw.ShipRecord) -> nw.ShipRecord:
    turns = np.full(len(record["rudder"]), kvlcc2().configuration.propeller.revolutions)
    told = {name: record[name] for name in MANOEUVRES} | {"revolutions": replace(record["rudder"], values=turns)}
    return replace(record, signals=told)


@cache
def manoeuvred(seed: int, turn: float) -> nw.ShipRecord:
    """A zigzag, or without a turn a circle, as a basin measures it."""
    law, duration = (nw.Zigzag(turn, abs(turn)), 600.0) if turn else (nw.ConstantRudder(35 * D), 900.0)
    name = f"zigzag {np.degrees(turn):+.0f}" if turn else "circle"
    voyage = trial(law, duration)
    told = of_manoeuvre(sensed(name, voyage, seed, noise=0.5))
    return told.with_signals(rudder=nw.Signal(voyage.t, voyage.rudder))


def records(seed: int = 0) -> list[nw.ShipRecord]:
    return [manoeuvred(seed + place, turn) for place, turn in enumerate((20 * D, -20 * D, 0.0))]


def begun(seed: int = 0, duration: float = 200.0) -> list[nw.ShipRecord]:
    """Their first minutes: time of a fit goes with that of the records."""
    return [record.between(0.0, duration) for record in records(seed)]


def errs(*names: str) -> dict[str, float]:
    """Spread of these coefficients alone: a fit takes a slope by each one that has a spread."""
    return {name: 0.1 * abs(mistaken()[name]) for name in names}


@cache
def learned_from_one() -> nw.LogFit:
    return nw.learn(mistaken(), records()[:1], sensors="basin", spread=0.1)


@cache
def learned() -> nw.LogFit:
    """What is wrong, and some of what is not."""
    return nw.learn(mistaken(), begun(), sensors="basin", spread=errs(*WRONG, "N_r", "Y_rrr"))


@pytest.mark.parametrize("every", [False, True], ids=["a few coefficients", "every coefficient"])
def test_a_ship_that_is_known_is_found_again(every: bool) -> None:
    found = nw.learn(mistaken(), begun(), sensors="basin", spread=0.1) if every else learned()
    off = {
        name: (found.model[name] - kvlcc2().coefficients.get(name, 0.0)) / std
        for name, std in found.std.items()
        if std > 0
    }
    assert max(map(abs, off.values())) < 3.5
    for name, factor in WRONG.items():
        assert abs(found.model[name] / kvlcc2()[name] - 1) < 0.5 * abs(factor - 1)
    assert found.converged
    assert found.informative
    assert found.verdicts["N_v"] == "learned"
    assert found.verdicts["Y_rrr"] == "from the prior"
    assert not found.disagrees


def test_what_was_left_out_is_predicted_better() -> None:
    before, after = learned().forecast_rmse("psi")
    assert after < 0.5 * before
    assert [record.name for record in learned().records] == ["zigzag +20", "zigzag -20", "circle"]
    shares = [record.information["N_v"] for record in learned().records]
    assert all(0 < share < 1 for share in shares)


def test_gusts_are_told_where_they_were_estimated() -> None:
    gusty = replace(learned(), gusts=Gusts(sway=0.002, yaw=3e-5, memory=25.0, correlation=0.1, strength=1.0))
    told = "Estimated gusts: 0.002 m/s2 in sway and 3e-05 rad/s2 in yaw (standard deviations), with a correlation time"
    assert told in gusty.summary()
    assert "Estimated gusts" not in learned().summary()


@pytest.mark.parametrize("ratio", [0.65, 1.3])
def test_the_log_of_another_ship_is_said_to_be_one_before_anything_is_learned(ratio: float) -> None:
    """Of the same form and of another length."""
    other = nw.scale_model(kvlcc2(), ratio * kvlcc2().ship.length).model
    law, free = nw.Zigzag(20 * D, 20 * D), {"contact": "none", "surge": "free"}
    voyage = nw.simulate(other, u=7.0, duration=450.0, dt=1.0, controller=law, **free)
    turns = np.full(len(voyage), other.configuration.propeller.revolutions)
    told = {name: nw.Signal(voyage.t, voyage[name]) for name in MANOEUVRES} | {
        "revolutions": nw.Signal(voyage.t, turns)
    }
    record = nw.ShipRecord("another", told)
    found = nw.learn(kvlcc2(), [record], sensors="basin", spread=0.1, asymmetry=False)
    assert found.disagrees
    assert "another ship" in found.summary().splitlines()[0]


def test_the_answer_says_what_was_learned_and_what_holds_the_rest() -> None:
    found = learned()
    first = found.summary().splitlines()[0]
    assert re.match(r"Learned from 3 records, 9.95 min: learned: R_0", first)
    assert "Unchanged from the prior: " in first
    assert any("inertia keeps its prior" in note for note in found.notes)
    assert "learned from 3 records of the ship itself" in found.model.source.text
    assert found.to_dict()["coefficients"][3]["name"] == "R_0"
    assert list(found.to_dataframe().columns)[:2] == ["prior", "prior_std"]


def test_a_learned_model_learns_on(tmp_path: Any) -> None:
    path = tmp_path / "learned.toml"
    learned().model.save(path)
    again = nw.load_model(path)
    assert again.verdicts["N_v"] == "identified"
    more = nw.learn(again, begun()[:1], sensors="basin")
    assert more.std["N_v"] < learned().std["N_v"]


def test_a_mirrored_ship_learns_the_mirrored_turns() -> None:
    def mirrored(record: nw.ShipRecord) -> nw.ShipRecord:
        turned = {name: -1.0 if name in ("psi", "y", "r", "rudder") else 1.0 for name in record}
        return replace(record, signals={n: replace(record[n], values=turned[n] * record[n].values) for n in record})

    gear = replace(kvlcc2().configuration.rudder, straightening_starboard=0.5, straightening_port=0.5)
    turning = replace(kvlcc2().configuration.propeller, wake_starboard=1.3, wake_port=1.3)
    even = replace(mistaken(), configuration=replace(mistaken().configuration, rudder=gear, propeller=turning))
    first = begun()[0]
    one, other = (nw.learn(even, [each], sensors="basin", spread=0.1) for each in (first, mirrored(first)))
    sides = {name: -1.0 if name not in even.coefficients else 1.0 for name in one.std}
    turned = [sides[name] * other.model[name] for name in one.std]
    prior = [own.prior_std for own in one.coefficients.values()]
    off = np.array([one.model[name] for name in one.std]) - turned
    assert (np.abs(off) <= 1e-4 * np.array(prior)).all()


def test_coefficients_that_are_held_stay_and_their_errors_count() -> None:
    """Free ones are those of the joint fit, nearer the truth than with the others taken for exact."""
    free = ("N_v", "N_r", "N_rudder")
    found = nw.learn(mistaken(), records()[:1], free=free, sensors="basin", spread=0.1, asymmetry=True)
    assert {name for name in found.std if found.model[name] != found.prior[name]} == set(free)
    for name in free:
        assert found.model[name] == pytest.approx(learned_from_one().model[name])
        assert found.std[name] == pytest.approx(learned_from_one().std[name])
    assert found.std["Y_v"] == pytest.approx(0.1 * abs(mistaken()["Y_v"]))
    blind = nw.learn(mistaken(), records()[:1], sensors="basin", spread=errs(*free), asymmetry=False)
    off = [[abs(fit.model[name] - kvlcc2()[name]) for name in free] for fit in (found, blind)]
    assert sum(off[0]) < 0.5 * sum(off[1])
    assert any("include the errors of the fixed coefficients" in note for note in found.notes)


def test_a_spike_moves_nothing_and_a_gap_is_not_sailed_over() -> None:
    clean = records()[0]
    values = clean["psi"].values.copy()
    values[200] += 1.5
    spiked = clean.with_signals(psi=nw.Signal(clean["psi"].t, values))
    rudder = clean["rudder"]
    kept = (rudder.t <= 250) | (rudder.t >= 320)
    broken = clean.with_signals(rudder=nw.Signal(rudder.t[kept], rudder.values[kept]))
    usual = learned_from_one()
    spike, gap = (nw.learn(mistaken(), [each], sensors="basin", spread=0.1) for each in (spiked, broken))

    def off(found: nw.LogFit) -> float:
        return max(abs(found.model[name] - usual.model[name]) / usual.std[name] for name in ("N_v", "N_rudder", "Y_v"))

    assert off(spike) < 0.3
    assert spike.noise["psi"].beyond == pytest.approx(1 / 500, rel=0.5)
    assert off(gap) < 3.0
    assert gap.std["N_v"] > usual.std["N_v"]


def test_steps_in_a_gap_are_not_whole() -> None:
    t = np.arange(0.0, 100.0, 0.5)
    seen = nw.Signal(t, 0.01 * t)
    gap = (t < 40) | (t > 52)
    record = nw.ShipRecord("gap", {"x": nw.Signal(t, t), "psi": seen, "rudder": nw.Signal(t[gap], 0 * t[gap])})
    grid = grid_of(record, 10.0, {"rudder": 0.0})
    assert grid.whole.tolist() == [True] * 3 + [False] * 3 + [True] * 3
    assert not np.isin(grid.readings["psi"].step, (3, 4, 5)).any()
    coarse = grid_of(record, 2.0, {"rudder": 0.0}).readings["psi"]
    np.testing.assert_allclose(coarse.values[:3], 0.01 * np.array([0.75, 2.75, 4.75]))
    assert (coarse.counted == 4).all()


def test_a_long_record_is_taken_in_parts() -> None:
    t = np.arange(0.0, 40_000.0, 100.0)
    record = nw.ShipRecord("long", {"x": nw.Signal(t, t)})
    cut = list(parts(record))
    assert [part.name for part in cut] == ["long, part 1", "long, part 2"]
    assert max(part.duration for part in cut) <= 20_000


@pytest.mark.parametrize(
    ("told", "says"),
    [
        ({"spread": None}, "state a spread"), ({"spread": -1.0}, "is none"), ({"free": ("N_vv",)}, "did you mean"),
        ({"sensors": "gps"}, "sensors"), ({"spread": {"N_vv": 0.1}}, "did you mean"), ({"log": 3}, "is no log"),
        ({"window": 3.0}, "no argument 'window'"),
    ],
)  # fmt: skip
def test_what_cannot_be_learned_from_is_said(told: dict[str, Any], says: str) -> None:
    usual = {"model": mistaken(), "log": records()[:1], "spread": 0.1, "sensors": "basin"}
    with pytest.raises(nw.InputError, match=says):
        nw.learn(**{**usual, **told})


def test_records_that_are_too_short_or_have_no_rudder_are_said() -> None:
    bare = replace(zigzag(), signals={name: zigzag()[name] for name in ("x", "y", "psi")})
    with pytest.raises(nw.InputError, match=r"no record of this log .* too short"):
        nw.learn(mistaken(), [of_manoeuvre(zigzag()).between(0, 5)], spread=0.1, sensors="basin")
    with pytest.raises(nw.InputError, match="has no rudder angle"):
        nw.learn(mistaken(), [bare], spread=0.1, sensors="basin")


def test_a_record_of_another_draft_is_left_out_and_said() -> None:
    usual, light, _ = begun(duration=100.0)
    both = [usual, replace(light, condition={"draft": 15.0})]
    found = nw.learn(mistaken(), both, free=("N_v",), sensors="basin", spread=errs("N_v", "N_r"))
    assert len(found.records) == 1
    assert any("of a draft of 15 m" in note for note in found.notes)


@pytest.mark.parametrize(("scores", "kept"), [(7, "3 records"), (1, "1 record")])
def test_an_interrupted_fit_keeps_what_is_done_and_says_so(
    scores: int, kept: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    done, usual = iter(range(scores)), RecordLikelihood.scored

    def stopped(*told: Any) -> Any:
        if next(done, None) is None:
            raise KeyboardInterrupt
        return usual(*told)

    monkeypatch.setattr(RecordLikelihood, "scored", stopped)
    found = nw.learn(mistaken(), begun(), sensors="basin", spread=errs(*WRONG))
    assert any(note.startswith("The search was interrupted") and f"from {kept}" in note for note in found.notes)
    assert abs(found.model["N_v"] / kvlcc2()["N_v"] - 1) < 0.12


def test_a_learned_model_says_where_it_comes_from() -> None:
    source = learned().model.source
    assert "3 records of the ship itself (zigzag +20 to circle, sensors basin, sha256 " in source.text
    assert source.sha256.endswith(_source(begun(), "basin", 3).sha256)
    assert _source(begun(1), "basin", 3).sha256 != _source(begun(), "basin", 3).sha256
