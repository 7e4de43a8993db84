"""The answer comes first, and what the tests do not settle is repeated by whatever uses the model."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import narrows as nw
from narrows.captive.measured import measured_files
from narrows.cli.fits import publish
from narrows.cli.options import Delivery
from narrows.identification.bank_summary import BankSummary, missing_runs, preferred_fit, summarise_bank
from narrows.report.envelope_chart import envelope_chart
from narrows.report.voyage_figures import map_figure, voyage_figure

SEPARATING = (
    *(nw.HarmonicRun(f"{kind}{u}{p}", kind, 0.5, p, u, 2) for kind in ("yaw", "sway") for u in (0.7, 1.0)
      for p in (14.0, 23.0)),
    *(nw.StraightRun(f"straight{y}{u}", y, u, 20.0) for y in (-2.0, -1.0, 1.0, 1.5, 2.0) for u in (0.7, 1.0)),
)  # fmt: skip
NOTE = "The tests do not determine the bank force: b_bank is not separable from b_r, c_bank is not separable from c_r."


@pytest.fixture(scope="module")
def settled() -> nw.Fit:
    return nw.identify(nw.twin(runs=SEPARATING, rate=5.0))


@pytest.fixture(scope="module")
def answer(kcs_fits: dict[int, nw.Fit]) -> BankSummary:
    return summarise_bank(kcs_fits[50])


def test_first_sentences_of_the_kcs(answer: BankSummary) -> None:
    fit = answer.fit
    hull, bank, runs = answer.sentences
    known = sum(fit.verdicts[term.name].status == "identified" for term in fit.terms.terms if not term.from_bank)
    assert hull.startswith(
        f"The tests identify {known} of 15 hull coefficients; the median 95 % interval of left-out motions"
    )
    assert bank.startswith(f"The tests do not determine the bank: b_bank {fit.coefficients['b_bank']:.3f} (")
    assert bank.endswith("; b_bank is not separable from b_r and c_bank is not separable from c_r.")
    assert runs.startswith("Run next: straight runs off the centreline to both sides at 0.62 m/s")
    (other,) = answer.details
    assert other.startswith("The terms crossflow predict left-out motions better")
    assert "b_bank is not separable from b_ur" in other


def test_the_preferred_terms_err_least(kcs_fits: dict[int, nw.Fit]) -> None:
    for fit in kcs_fits.values():
        other = preferred_fit(fit)
        assert other.terms.name == "crossflow"
        assert all(other.left_out[force].rmse < fit.left_out[force].rmse for force in "YN")
        assert preferred_fit(other) is None


def test_runs_that_part_the_bank_are_not_asked_for_again(settled: nw.Fit, dtc: nw.Model) -> None:
    answer = summarise_bank(settled)
    assert answer.settled
    assert answer.sentences[1].startswith("The tests identify the bank: b_bank 1.")
    assert answer.details[0].startswith("b_bank is off by a standard error with ")
    assert missing_runs(settled) == []
    assert settled.model.trust_note == ""
    low, high = settled.intervals["b_bank"]
    assert low < dtc.coefficients["b_bank"] < high
    one_period = nw.identify(nw.twin(runs=SEPARATING[::2], rate=5.0))
    assert any("two periods" in ask for ask in missing_runs(one_period))


def test_terms_without_a_bank_and_tests_that_are_wrong(short: nw.CaptiveTests) -> None:
    tests = short
    assert summarise_bank(nw.identify(tests, "paper+open_water")).sentences[1].endswith("have no bank.")
    turned = replace(tests, columns={**tests.columns, "N": -tests.columns["N"]})
    wrong = summarise_bank(nw.identify(turned)).sentences[1]
    assert wrong.startswith("Do not trust the bank's coefficients: N of the other sign")


def test_first_in_terminal_and_json(answer: BankSummary, cli, capsys: pytest.CaptureFixture[str]) -> None:
    publish({"": answer.fit}, "", Delivery())  # What the command does with its fit
    out = capsys.readouterr().out
    assert " ".join(out.split()).partition("h/T = 1.50 ")[2].startswith(answer.sentences[0])
    table, ship = measured_files("kcs")
    code, out, _ = cli("identify", table, "--ship", ship, "--condition", "C0101A02", "--json")
    assert code == 0
    assert json.loads(out)["answer"] == answer.to_dict() | {"preferred_terms": "crossflow"}


@pytest.fixture(scope="module")
def model(kcs_fits: dict[int, nw.Fit]) -> nw.Model:
    return kcs_fits[50].model


def test_verdicts_travel_in_the_model_file(model: nw.Model, tmp_path: Path) -> None:
    model.save(tmp_path / "m.toml")
    again = nw.load_model(tmp_path / "m.toml")
    assert again.verdicts == model.verdicts
    assert again.verdicts["b_vdot"] in ("identified", "imprecise")
    assert again.trust_note == NOTE
    assert again.in_open_water().trust_note == ""
    assert again.with_coefficients(b_bank=1.0, c_bank=0.1).trust_note == ""
    text = (tmp_path / "m.toml").read_text()
    (tmp_path / "m.toml").write_text(text.replace("[verdicts]", "[verdicts]\nb_bonk = 'identified'"))
    with pytest.raises(nw.InputError, match="'b_bonk' is no words on a coefficient"):
        nw.load_model(tmp_path / "m.toml")


def test_models_without_verdicts_say_nothing(dtc: nw.Model) -> None:
    assert dtc.verdicts == {}
    assert dtc.trust_note == ""


def test_simulate_and_map_repeat_it(model: nw.Model) -> None:
    voyage = nw.simulate(model, y=0.5, u=0.6, duration=2.0)
    assert NOTE in voyage.summary()
    assert voyage.to_dict()["notes"][0] == NOTE
    assert any(NOTE in text.get_text().replace("\n", " ") for text in voyage_figure(voyage).texts)
    voyages = nw.ensemble(model, y=np.array([-1.0, 1.0]), u=0.6, duration=2.0, samples=3)
    assert voyages.attrs["notes"].splitlines()[0] == NOTE
    picture = map_figure(voyages, model)
    assert any(NOTE in text.get_text().replace("\n", " ") for text in picture.texts)


def test_scaling_keeps_the_verdicts_and_the_envelope_repeats_them() -> None:
    tests = nw.read_captive(*measured_files("kcs"), "type in ('PMMY2', 'PMMPSI2') and abs(rud_given_deg) < 31")
    fit = nw.identify(tests.by_condition()["C0101A02"], "speed+helm")
    full = nw.scale_model(fit.model, 230.0, width=300.0, depth=16.2)
    assert full.model.trust_note.startswith("The tests do not determine the bank force")
    assert full.notes[0] == full.model.trust_note
    answer = nw.safe_envelope(full.model, [0.0, 20.0], [4.0], samples=4)
    assert answer.summary().endswith(full.model.trust_note)
    assert answer.to_dict()["notes"][0] == full.model.trust_note
    assert "do not determine" in envelope_chart(answer).get_suptitle().replace("\n", " ")
