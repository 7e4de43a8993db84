"""Pages in a headless Chromium: no error, no request, the package's own numbers; refusals that write nothing."""

import subprocess
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from exported import model_of
from opened_pages import opened, settled

import narrows as nw
from browsers import chromium
from narrows.export.page import assembly
from narrows.export.page.assembly import helm_of

LARGEST = 100_000
BESIDE = "[...document.querySelectorAll('header p, header li')].map(one => one.textContent).join(' ')"
DARK = "[...document.getElementById('canal').getContext('2d').getImageData(3, 3, 1, 1).data].slice(0, 3)"


@pytest.fixture(scope="module")
def paper(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("page") / "dtc.html"
    nw.export.write_page(nw.published("mikkelsen2025_dtc"), path)
    return path


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as browser:
        yield browser


@pytest.fixture(scope="module")
def shown(paper: Path, browser: Any) -> tuple[Any, list[str]]:
    return opened(browser, paper, 1280, 800)


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


def test_the_headline_says_which_way_the_bow_turns(shown: tuple[Any, list[str]]) -> None:
    page, wrong = shown
    for y, near, away in ((0.5, "starboard", "port"), (-0.5, "port", "starboard")):
        put(page, y=y)
        said = page.inner_text("#turning")
        assert said == f"The {near} bank is nearer, and turns the bow to {away}, away from it."
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
    assert "Beyond the data: start, to starboard." in page.evaluate(BESIDE)
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
    page.focus("#map")
    before = page.evaluate("narrowsPage.settings.values.u")
    page.keyboard.press("ArrowLeft")
    assert page.evaluate("narrowsPage.settings.values.u") < before
    with page.expect_download() as saved:
        page.click("#save")
    assert Path(saved.value.path()).read_bytes().startswith(b"\x89PNG")
    assert wrong == []


def test_a_phone_held_upright_at_night(paper: Path, browser: Any) -> None:
    page, wrong = opened(browser, paper, 390, 844, color_scheme="dark", has_touch=True)
    assert wrong == []
    assert page.evaluate("document.documentElement.scrollWidth") == 390
    assert page.evaluate("document.documentElement.dataset.palette") == "dusk"
    while page.evaluate("document.documentElement.dataset.palette") != "night":
        page.click("#palette")
    assert max(page.evaluate(DARK)) < 40
    box = page.locator("#canal").bounding_box()
    assert box["height"] > 1.3 * box["width"]


@pytest.mark.slow
def test_the_helm_of_a_page_steers_as_the_regulator_does(tmp_path: Path, browser: Any) -> None:
    model = model_of("steered")
    assert nw.export.write_page(model, tmp_path / "ship.html", u=1.0)[-1:] in ((), (assembly.lacks_zig(),))
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
            nw.export.write_page(model, tmp_path / path, **told)
    deep = model_of("paper+keel_gap")
    shallow = replace(deep, configuration=replace(deep.configuration, canal=nw.Canal(7.0)))
    with pytest.raises(nw.InputError, match="depth"):
        nw.export.write_page(shallow, tmp_path / "a.html")
    failed = subprocess.CompletedProcess([], 1, "", "fleet.c:3: error: no room left on device")
    monkeypatch.setattr(assembly, "lacks_zig", str)
    monkeypatch.setattr(assembly.subprocess, "run", lambda *_, **__: failed)
    with pytest.raises(nw.InputError, match="no room left on device"):
        nw.export.write_page(model, tmp_path / "a.html")
    assert list(tmp_path.iterdir()) == []
