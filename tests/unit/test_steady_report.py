"""Steady legs on paper: a side that a pilot can follow, a page that says what was learned, and the verb."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from test_plan_steady import CALM, ship

import narrows as nw
from narrows.report.learning_pages import rudder_band, write_pilot_page, write_steady_report
from pictures import assert_readable

LEGS = {"y": [0.4, -0.4], "u": [0.7, 0.7], "rudder [deg]": [4.0, -3.5], "drift [deg]": [0.4, -0.5]}


@cache
def planned(legs: int) -> nw.SteadyPlan:
    return nw.plan_steady(ship(), legs=legs, conditions=CALM)


@cache
def learned() -> nw.SteadyFit:
    return nw.learn_steady(ship(), LEGS, conditions=CALM)


def test_what_each_leg_adds_is_drawn() -> None:
    drawn = planned(4).plot()
    for axes, std in zip(drawn.axes, planned(4).std.values(), strict=True):
        assert axes.lines[0].get_xydata().tolist() == [[count, std[count]] for count in range(5)]
    assert_readable(drawn)
    with pytest.raises(nw.InputError, match="a plan without legs has no picture"):
        nw.plan_steady(ship(bank=3.0)).plot()


def test_the_pilots_page_says_when_to_break_off_and_what_it_rests_on(tmp_path: Path) -> None:
    write_pilot_page(planned(4), tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    for said in (
        "BREAK OFF", f"{np.degrees(planned(4).most_rudder):.0f} degrees", "on simulated twins only",
        f"<td>{planned(4).legs[0]['offset']:g} m starboard</td>",
    ):  # fmt: skip
        assert said in page


def test_the_report_says_what_was_learned_and_what_it_rests_on(tmp_path: Path) -> None:
    fit = learned()
    write_steady_report(fit, tmp_path / "learned.html")
    page = (tmp_path / "learned.html").read_text(encoding="utf-8")
    for said in ("on simulated twins only", "c_bank", "Wind and zeros", "zero of the rudder", "<svg"):
        assert said in page
    assert len(fit.plot().axes) == 3
    assert_readable(fit.plot())


def test_surer_coefficients_narrow_the_rudder_that_holds_the_ship() -> None:
    surer, y = replace(ship(0.2), covariance=ship(0.2).covariance / 100), np.array([-0.4, 0.4])
    wide, narrow = (np.ptp(rudder_band(model, y, 0.5), axis=0) for model in (ship(0.2), surer))
    assert (narrow < wide).all()


def test_the_verb_plans_and_writes_the_page(cli, tmp_path: Path) -> None:
    nw.save_model(ship(), tmp_path / "full.toml")
    code, out, err = cli(
        "learn", str(tmp_path / "full.toml"), "--plan-steady", str(tmp_path / "page.html"), "--legs", "2"
    )
    assert code == 0, err
    assert "wrote" in out
    assert (tmp_path / "page.html").exists()


def test_the_verb_leaves_with_one_where_no_leg_is_allowed(cli, tmp_path: Path) -> None:
    nw.save_model(ship(bank=3.0), tmp_path / "full.toml")
    code, out, _ = cli("learn", str(tmp_path / "full.toml"), "--plan-steady", str(tmp_path / "page.html"))
    assert code == 1
    assert "No leg off the middle is allowed" in out
    assert not (tmp_path / "page.html").exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ((), "exactly one of"),
        (("--steady", "held.csv", "--plan-steady", "page.html"), "exactly one of"),
        (("--plan-steady", "page.html", "-o", "new.toml"), "--output goes with LOG or --steady"),
        (("--plan-steady", "page.txt"), "cannot write a txt file"),
        (("--steady", "none.csv"), "no such file"),
    ],
)
def test_words_that_do_not_go_together_are_refused(words: tuple[str, ...], said: str, cli, tmp_path: Path) -> None:
    nw.save_model(ship(), tmp_path / "full.toml")
    code, _, err = cli("learn", str(tmp_path / "full.toml"), *words)
    assert code == 2
    assert said in err


def test_the_verb_predicts_and_says_where_it_cannot(cli, tmp_path: Path) -> None:
    nw.save_model(ship(), tmp_path / "full.toml")
    code, _, err = cli("learn", str(tmp_path / "full.toml"), "--predict-information", "ais")
    assert code == 2
    assert "record the rudder" in err
    code, _, err = cli(
        "learn", str(tmp_path / "full.toml"), "--plan-steady", "page.html", "--waterway", "canal.geojson"
    )
    assert code == 2
    assert "--waterway goes with LOG or --predict-information" in err
