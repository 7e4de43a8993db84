"""Pages in a headless Chromium: no error, no request, the package's own numbers; refusals that write nothing."""

import re
import subprocess
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from exported import model_of
from opened_pages import opened, settled
from scipy.stats import norm

import narrows as nw
from browsers import chromium
from narrows.export.exported_ship import ExportedShip
from narrows.export.page import assembly
from narrows.export.page.assembly import helm_of
from narrows.simulation.ship import SimulatedShip, steering_of

LARGEST = 100_000
BESIDE = "[...document.querySelectorAll('header p, header li')].map(one => one.textContent).join(' ')"
DARK = "[...document.getElementById('canal').getContext('2d').getImageData(3, 3, 1, 1).data].slice(0, 3)"

# Whether the map draws lines of both kinds, and the solid ones of its crosshair to the edges.
DASHED = """(() => {
  const pen = document.getElementById('map').getContext('2d');
  let [dashed, dash, stroke, set] = [[], [], pen.stroke, pen.setLineDash];
  pen.setLineDash = (one) => { dash = one; set.call(pen, one); };
  pen.stroke = () => { dashed.push(dash.length > 0); stroke.call(pen); };
  narrowsPage.scene.recoloured();
  delete pen.stroke, delete pen.setLineDash;
  return dashed.join() === 'true,false,false,false';
})()"""


@pytest.fixture(scope="module")
def paper(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("page") / "dtc.html"
    nw.export.write(nw.published("mikkelsen2025_dtc"), path)
    return path


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as browser:
        yield browser


@pytest.fixture(scope="module")
def shown(paper: Path, browser: Any) -> tuple[Any, list[str]]:
    return opened(browser, paper, 1280, 800)


@pytest.fixture(autouse=True)
def closed(browser: Any, shown: tuple[Any, list[str]]) -> Iterator[None]:
    """Close what a test opens: its ships would sail on while others are tested."""
    before = list(browser.contexts)
    yield
    for context in [own for own in browser.contexts if own not in before]:
        context.close()


def put(page: Any, **values: float) -> None:
    """Change settings as sliders do, and wait for the voyage, not for all the others."""
    page.evaluate("values => { Object.assign(narrowsPage.settings.values, values); narrowsPage.changed(); }", values)
    drawn(page)


def drawn(page: Any) -> None:
    """Wait for two frames."""
    page.evaluate("() => new Promise((one) => requestAnimationFrame(() => requestAnimationFrame(one)))")


def test_a_page_is_small_and_asks_for_nothing(paper: Path, shown: tuple[Any, list[str]]) -> None:
    page, wrong = shown
    assert paper.stat().st_size < LARGEST
    assert wrong == []
    assert page.evaluate("document.documentElement.scrollWidth") <= 1280
    assert "http" not in page.evaluate("document.getElementById('data').textContent")
    assert "may be used" in page.inner_html("footer details")


def test_a_page_says_that_it_computes(paper: Path, browser: Any) -> None:
    """Its workers never answer."""
    page = browser.new_page()
    page.add_init_script("window.Worker = class { postMessage() {} }")
    page.goto(paper.as_uri())
    page.wait_for_selector("text='Computing 3,000 ships ...'")


def test_the_headline_says_which_way_the_bow_may_turn(shown: tuple[Any, list[str]]) -> None:
    """The model has neither verdicts nor a covariance: what its ships do is no fact, and their spread is assumed."""
    page, wrong = shown
    for y, near, away in ((0.5, "starboard", "port"), (-0.5, "port", "starboard")):
        put(page, y=y)
        said = page.inner_text("#turning")
        assert said.startswith(f"At the start the {near} bank is nearer. It may turn the bow to {away}, away from it")
        assert "how well its tests determine this is not known" in said
        assert "The spread of the ships is assumed: each coefficient ± 5 %." in page.evaluate(BESIDE)
        assert said in page.get_attribute("#canal", "aria-label")
    assert wrong == []


@pytest.mark.parametrize(("y", "u", "psi", "width"), [(0.5, 1.0, 0.0, 7.0), (-1.4, 0.7, 2.0, 6.3)])
def test_the_solid_ship_grounds_where_that_of_python_does(
    shown: tuple[Any, list[str]], y: float, u: float, psi: float, width: float
) -> None:
    page, _ = shown
    put(page, y=y, u=u, psi=psi, width=width)
    model = nw.published("mikkelsen2025_dtc")
    model = replace(model, configuration=replace(model.configuration, canal=nw.Canal(width)))
    outcome = nw.simulate(model, y=y, u=u, psi=np.radians(psi), dt=3.984 / 200 / u, duration=7 * 3.984 / u).outcome
    alone = page.evaluate("narrowsPage.scene.now.alone")
    assert alone["kind"] == outcome.side
    assert abs(alone["time"] - outcome.time) < 1e-9
    assert abs(alone["x"] - outcome.state["x"]) < 1e-9
    assert f"touches the {outcome.side} bank after {outcome.time:.1f} s" in page.inner_text("#alone")


def test_cells_of_the_map_are_voyages_of_python(shown: tuple[Any, list[str]]) -> None:
    page, _ = shown
    put(page, y=0.5, u=1.0, psi=0.0, width=7.0)
    settled(page)
    across, cells, ended = page.evaluate(
        "(({ across, cells, ended }) => [across, cells, ended])(narrowsPage.scene.now.map)"
    )
    low, high = page.evaluate("JSON.parse(document.getElementById('data').textContent).speeds")
    model = nw.published("mikkelsen2025_dtc")
    for place in range(7, len(cells), len(cells) // 6):
        row, column = divmod(cells[place], across)
        y, u = ((row + 0.5) / across - 0.5) * 7.0, low + (column + 0.5) / across * (high - low)
        outcome = nw.simulate(model, y=y, u=u, dt=3.984 / 100 / u, duration=7 * 3.984 / u).outcome
        assert ended[place]["kind"] == (outcome.side if outcome.kind == "grounded" else "sails")
        assert abs(ended[place]["x"] - outcome.state["x"]) < 2e-4


def test_settings_go_into_the_address_and_come_out_of_it(paper: Path, shown: tuple[Any, list[str]]) -> None:
    page, _ = shown
    put(page, y=-0.8, u=0.9, c_bank=0.2)
    assert set(page.evaluate("location.hash").removeprefix("#").split("&")) >= {"y=-0.8", "u=0.9", "c_bank=0.2"}
    page.evaluate("location.hash = '#y=99&psi=12&u=no&b_bank=0.5'")
    page.wait_for_function("narrowsPage.settings.values.psi == 12")
    drawn(page)
    values = page.evaluate("narrowsPage.settings.values")
    assert (values["u"], values["b_bank"], values["c_bank"]) == (1.0, 0.5, 0.13)
    assert "There is no room for that: the ship starts" in page.evaluate(BESIDE)
    assert "Beyond the data: start, to starboard (tested: 0–0.91 m)." in page.evaluate(BESIDE)
    page.click("#first")
    drawn(page)
    assert page.evaluate("location.hash") in ("", "#")


def test_sliders_keys_and_clicks_set_a_voyage(shown: tuple[Any, list[str]]) -> None:
    page, wrong = shown
    page.click("#first")
    page.focus("input[name=y]")
    page.keyboard.press("ArrowRight")
    first, step = page.evaluate(
        "[narrowsPage.settings.first.y, JSON.parse(data.textContent).sliders.find(s => s.name == 'y').step]"
    )
    assert abs(page.evaluate("narrowsPage.settings.values.y") - first - step) < 1e-9
    box = page.locator("#map").bounding_box()
    page.mouse.click(box["x"] + 0.7 * box["width"], box["y"] + 0.3 * box["height"])
    assert page.evaluate("narrowsPage.settings.values.y") < -0.5
    assert page.evaluate(DASHED), "dotted lines are the tests' alone"
    page.focus("#map")
    before = page.evaluate("narrowsPage.settings.values.u")
    page.keyboard.press("ArrowLeft")
    assert page.evaluate("narrowsPage.settings.values.u") < before
    with page.expect_download() as saved:
        page.click("#save")
    assert Path(saved.value.path()).read_bytes().startswith(b"\x89PNG")
    assert wrong == []


def test_a_slider_tells_that_its_coefficient_has_no_verdict(paper: Path) -> None:
    """The published model has none: its coefficients must not look like identified ones."""
    assert '"b_bank, no verdict"' in paper.read_text(encoding="utf-8")


def test_a_phone_held_upright_at_night(paper: Path, browser: Any) -> None:
    page, wrong = opened(browser, paper, 390, 844, color_scheme="dark", has_touch=True)
    assert wrong == []
    assert page.evaluate("document.documentElement.scrollWidth") == 390
    assert page.evaluate("document.documentElement.dataset.palette") == "dusk"
    while page.evaluate("document.documentElement.dataset.palette") != "night":
        page.click("#palette")
    assert max(page.evaluate(DARK)) < 40
    assert page.locator("input[name=u]").bounding_box()["y"] < 844, "the first slider is on the first screen"
    page.evaluate("document.querySelector('input[name=width]').scrollIntoView()")
    page.wait_for_function("scrollY > 0")
    assert abs(page.locator("#canal").bounding_box()["y"]) < 1, "the picture stays in sight of the sliders"
    assert page.locator("#canal").bounding_box()["width"] < 390, "no bar of the histogram is cut"
    for words in ("The solid ship touches", "The arrow at the bow", "Bars in the banks"):
        assert page.get_by_text(words).first.is_visible()
    assert not page.get_by_text("Pause to swipe").is_visible()
    put(page, width=1.5, y=0.0)  # A narrow canal is drawn larger than the screen, and follows the ship
    page.wait_for_function("strip.scrollLeft > 100")
    assert page.get_by_text("Pause to swipe").is_visible()


def test_a_headline_doubts_what_the_tests_do_not_settle(tmp_path: Path, browser: Any) -> None:
    """A third of the ships that the covariance allows turn the other way: the first line says so, in plain words."""
    model = nw.published("mikkelsen2025_dtc")
    size = [0.02 * abs(value) + 1e-9 if name != "c_bank" else 2.4 * value for name, value in model.coefficients.items()]
    doubted = replace(model, covariance=np.diag(np.square(size)), verdicts={"c_bank": "weakly identified"})
    nw.export.write(doubted, tmp_path / "ship.html")
    page, wrong = opened(browser, tmp_path / "ship.html", 1280, 800)
    said = page.inner_text("#turning")
    expected = 100 * float(norm.cdf(-1 / 2.4))
    shares = [int(word) for word in said.replace("%", "").split() if word.isdigit()]
    assert "It may turn" in said
    assert "the tests do not settle this" in said
    assert abs(shares[0] - expected) < 8
    assert "c_bank" not in page.evaluate(BESIDE)
    sure = replace(doubted, covariance=np.diag(np.square(size)) / 400, verdicts={})
    nw.export.write(sure, tmp_path / "sure.html")
    assert "and turns the bow" in opened(browser, tmp_path / "sure.html", 1280, 800)[0].inner_text("#turning")
    assert wrong == []


def test_a_model_without_a_bank_says_so(tmp_path: Path, browser: Any) -> None:
    """In a canal a hundred ship lengths wide: the picture shows the ship, not the banks."""
    notes = nw.export.write(nw.published("yasukawa2015_kvlcc2"), tmp_path / "ship.html")
    assert any("mmg+delta" in note for note in notes)
    page, wrong = opened(browser, tmp_path / "ship.html", 1280, 800)
    assert page.inner_text("#turning") == "This model has no bank force: the ship sails in open water."
    said = page.evaluate("document.body.innerText").partition("What this model rests on")[0]
    assert not re.search("banks|canal|port bank|middle|Bars|map", said.replace("no bank force", "")), said
    assert "in open water" in page.title()
    settled(page)
    assert page.inner_text("#fleet") == "All 500 ships still sail after 49 m."
    assert page.inner_text("#alone") == "The solid ship still sails at the end, 1.6 m to starboard of the dashed line."
    assert "in open water; with" in page.inner_text("footer")
    assert not page.locator("#map").is_visible()
    assert not page.locator("#field").is_visible()
    assert page.locator("#canal").bounding_box()["height"] > 200
    put(page, rudder=35.0)
    settled(page)
    assert "turn by more than 90°" in page.inner_text("#fleet")
    assert wrong == []


def test_a_canal_without_a_bank_force_still_has_banks(tmp_path: Path, browser: Any) -> None:
    model = nw.published("yasukawa2015_kvlcc2")
    narrow = replace(model, configuration=replace(model.configuration, canal=nw.Canal(20.0)))
    nw.export.write(narrow, tmp_path / "ship.html")
    page, wrong = opened(browser, tmp_path / "ship.html", 1280, 800)
    assert "until it touches a bank" in page.inner_text("#turning")
    settled(page)
    assert "in a canal 20 m wide" in page.inner_text("footer")
    assert page.locator("#map").is_visible()
    assert wrong == []


def test_beyond_the_data_follows_the_voyage(shown: tuple[Any, list[str]]) -> None:
    """The start is within the tests; the way to the bank is not, from the second on that Python says."""
    page, _ = shown
    page.click("#first")
    drawn(page)
    model = nw.published("mikkelsen2025_dtc")
    y, u = page.evaluate("[narrowsPage.settings.values.y, narrowsPage.settings.values.u]")
    voyage = nw.simulate(model, y=y, u=u, dt=3.984 / 200 / u, duration=7 * 3.984 / u)
    limit = 1.01 * model.data_range.abs_y[1]
    left = voyage.t[np.abs(voyage.y) > limit][0]
    said = page.evaluate(BESIDE)
    assert "farther off the middle than in the tests" in said
    assert 0 <= float(said.split("From ")[1].split(" s")[0]) - left < 0.4


def test_lengths_of_a_full_size_ship_are_written_out(tmp_path: Path, browser: Any) -> None:
    full = nw.published("mikkelsen2025_dtc").scale(355.0).model
    full = replace(
        full, source=replace(full.source, estimate="of a test"), verdicts={"c_bank": "estimated from other ships"}
    )
    nw.export.write(full, tmp_path / "ship.html")
    page, _ = opened(browser, tmp_path / "ship.html", 1280, 800)
    said = page.evaluate("document.body.innerText")
    assert "e+" not in said
    assert "what the tests covered" not in said
    assert re.search(r"within 1,\d\d\d? ?\d*0? m", page.inner_text("#fleet"))
    assert "this ship was not tested" in page.inner_text("#turning")
    assert "estimated from other ships" in page.evaluate(BESIDE)
    assert "tests" not in page.inner_text("#turning").replace("tested", "")
    assert "in a canal 623.7 m wide, of unknown depth. Sailed" in page.inner_text("footer")
    page.fill("input[name=width]", "300")
    drawn(page)
    assert "in a canal 300 m wide" in page.inner_text("footer"), "the slider reaches it, and the foot follows"


def test_first_turn_and_end_of_an_estimated_ship_are_one_story(tmp_path: Path, browser: Any) -> None:
    """Many ships turn away from one bank and ground on it later: the words say so, and that the maps show one ship."""
    model = nw.published("estimated_inland")
    nw.export.write(model, tmp_path / "ship.html")
    page, wrong = opened(browser, tmp_path / "ship.html", 1280, 800)
    settled(page)
    ended, first = page.evaluate(
        "[narrowsPage.scene.now.ended, narrowsPage.scene.now.turning(narrowsPage.scene.now.first)]"
    )
    away, other = ("starboard", "port") if first > 0 else ("port", "starboard")
    grounded = {side: sum(one["kind"] == side for one in ended) / len(ended) for side in (away, other)}
    back, agree = page.evaluate("[narrowsPage.scene.now.back, narrowsPage.scene.now.agree]")
    aground = sum(grounded.values())
    assert back * aground >= grounded[other] - (1 - agree) - 0.06, "who ends where it did not first turn came back"
    fates, _, came = page.inner_text("#fleet").partition("Of those that ground")
    assert sum(map(int, re.findall(r"(\d+)\s%", fates))) == 100
    assert f"{100 * back:.0f}" in came
    assert ("come back from their first turn" in page.inner_text("#fleet")) == (back >= 0.05)
    assert "in a canal 55 m wide, 4 m deep; with propeller, rudder. Sailed" in page.inner_text("footer")
    assert "than in the tests" not in page.evaluate(BESIDE)
    assert "solid ship alone" in page.inner_text("#single")
    assert "dotted: what tests of other ships covered" in page.inner_text(".map .key")
    assert model.data_range.width_to_beam is not None
    least = model.data_range.width_to_beam[0] * model.configuration.ship.beam
    assert f"the width of the canal (other ships: {least:.3g}–" in page.evaluate(BESIDE)
    assert wrong == []


def test_a_page_without_scripts_and_for_screen_readers(paper: Path, shown: tuple[Any, list[str]]) -> None:
    page, _ = shown
    hint = paper.read_text(encoding="utf-8").partition("<noscript>")[2].partition("</noscript>")[0]
    assert "needs JavaScript" in hint
    assert page.locator("input[type=checkbox][aria-valuetext]").count() == 0
    style = "getComputedStyle(document.documentElement)"
    for name in ("port", "starboard"):
        colours = page.evaluate(f"['page', '{name}'].map((one) => {style}.getPropertyValue(`--${{one}}`))")
        assert contrast(*colours) >= 4.5, "WCAG 2.2, 1.4.3"


def contrast(one: str, other: str) -> float:
    """Ratio of the relative luminances of two colours, by WCAG 2.2."""

    def luminance(colour: str) -> float:
        parts = [int(colour.strip()[place : place + 2], 16) / 255 for place in (1, 3, 5)]
        linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]

    light = sorted(map(luminance, (one, other)))
    return (light[1] + 0.05) / (light[0] + 0.05)


def test_the_sliders_are_those_of_the_ship_and_its_canal() -> None:
    """Without a browser: helm and rudder where it steers, the depth of its canal."""

    def sliders(name: str) -> dict[str, Any]:
        model = model_of(name)
        ship, (helm, _) = SimulatedShip(model), helm_of(model, 1.0)
        exported = ExportedShip(ship, None, assembly.SHIP, steering_of(helm, ship.actuators))
        return {one["name"]: one for one in assembly.sliders_of(exported, 1.0)}

    steered, deep = sliders("steered"), sliders("paper+keel_gap")
    assert (steered["helm"]["label"], steered["helm"]["switch"]) == ("helm: hold the middle", True)
    assert (steered["rudder"]["low"], steered["rudder"]["high"], steered["rudder"]["value"]) == (-25.0, 25.0, 0)
    assert not {"helm", "rudder"} & deep.keys()
    draft = model_of("paper+keel_gap").configuration.ship.draft
    assert deep["depth"]["low"] == pytest.approx(1.1 * draft, abs=deep["depth"]["step"])
    assert deep["depth"]["high"] == pytest.approx(4.0 * draft, abs=deep["depth"]["step"])
    assert deep["depth"]["value"] == 0.3


@pytest.mark.slow
def test_the_helm_of_a_page_steers_as_the_regulator_does(tmp_path: Path, browser: Any) -> None:
    model = model_of("steered")
    assert nw.export.write(model, tmp_path / "ship.html", u=1.0)[-1:] in (
        (),
        (f"{assembly.SLOWER}: {assembly.lacks_zig('WebAssembly')}",),
    )
    page, wrong = opened(browser, tmp_path / "ship.html", 1280, 800)
    put(page, y=0.2, helm=1, u=0.9)
    helm = helm_of(model, 1.0)[0]
    assert helm is not None
    outcome = nw.simulate(
        model, y=0.2, u=0.9, dt=3.984 / 200 / 0.9, duration=7 * 3.984 / 0.9, controller=helm.law
    ).outcome
    alone = page.evaluate("narrowsPage.scene.now.alone")
    assert (alone["kind"], outcome.kind) == ("sails", "afloat")
    assert abs(alone["y"] - outcome.state["y"]) < 1e-9
    assert "The helm answers" in page.inner_text("#turning")
    assert wrong == []


def test_refusals_write_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    model = nw.published("mikkelsen2025_dtc")
    for path, told in (
        ("a.txt", {}),
        ("a.html", {"contact": "none"}),
        ("a.html", {"u": 0.0}),
        ("a.html", {"u": np.nan}),
    ):
        with pytest.raises(nw.InputError):
            nw.export.write(model, tmp_path / path, **told)
    deep = model_of("paper+keel_gap")
    shallow = replace(deep, configuration=replace(deep.configuration, canal=nw.Canal(7.0)))
    with pytest.raises(nw.InputError, match="depth"):
        nw.export.write(shallow, tmp_path / "a.html")
    failed = subprocess.CompletedProcess([], 1, "", "fleet.c:3: error: no room left on device")
    monkeypatch.setattr(assembly, "lacks_zig", lambda what: "")
    monkeypatch.setattr(subprocess, "run", lambda *_, **__: failed)
    with pytest.raises(nw.InputError, match="no room left on device"):
        nw.export.write(model, tmp_path / "a.html")
    assert list(tmp_path.iterdir()) == []
