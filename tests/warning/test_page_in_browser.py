"""The monitor's page in a real browser: what it asks for, how it fits, what a keyboard does, and when it is too old."""

from collections.abc import Iterator
from typing import Any

import pytest
from shown_page import ALARM, BANK, Pulse, Watched, asked, forecast, soon

from browsers import chromium
from narrows.warning.alerts.alert import NO_FORECAST, OTHER_DEPTH, Condition, Priority
from narrows.warning.page.bridge_page import BridgePage

SIZES = {"desktop": (1440, 900), "panel": (1280, 800), "old": (1024, 768), "phone": (390, 844)}
URGENT = {**ALARM, OTHER_DEPTH: Condition(Priority.CAUTION, "Beyond the data: speed 4.2 m/s.")}


@pytest.fixture(scope="module")
def pulse() -> Iterator[Pulse]:
    pytest.importorskip("websockets", reason="of the extra monitor")
    page = BridgePage()
    with page.open() as address, Pulse(page, Watched()).running() as pulse:
        pulse.address = address
        yield pulse


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as browser:
        yield browser


@pytest.fixture(scope="module")
def shown(browser: Any, pulse: Pulse) -> Any:
    """The page, and what it complained of and asked for."""
    shown = browser.new_page()
    shown.troubles, shown.asked = [], []
    shown.on("pageerror", lambda error: shown.troubles.append(str(error)))
    shown.on("console", lambda said: shown.troubles.append(said.text) if said.type in ("error", "warning") else None)
    shown.on("request", lambda request: shown.asked.append(request.url))
    shown.on("websocket", lambda line: shown.asked.append(line.url))
    shown.goto(pulse.address)
    return shown


@pytest.fixture
def page(shown: Any, pulse: Pulse) -> Iterator[Any]:
    """The page of a ship that is clear, in its usual size."""
    pulse.monitored.__init__()
    pulse.status, pulse.beats = pulse.monitored.status(forecast()), True
    shown.set_viewport_size({"width": 1280, "height": 800})
    fresh(shown, "Clear")
    yield shown
    assert shown.troubles == []


def fresh(page: Any, word: str) -> None:
    page.wait_for_function("word => document.querySelector('h1').textContent === word", arg=word)
    page.wait_for_selector("html:not([data-stale])")


def say(pulse: Pulse, page: Any, word: str, *told: Any, **conditions: Any) -> None:
    pulse.status = pulse.monitored.status(*told, **conditions)
    fresh(page, word)


def background(page: Any) -> str:
    return page.evaluate("getComputedStyle(document.querySelector('.status')).backgroundColor")


def test_it_asks_for_nothing_from_elsewhere(page: Any, pulse: Pulse) -> None:
    host = pulse.address.split("/")[2]
    assert len(page.asked) > 10
    assert {url.split("/")[2] for url in page.asked if not url.startswith("data:")} == {host}


@pytest.mark.parametrize("size", SIZES)
def test_it_fits_the_screen_with_all_that_matters(page: Any, pulse: Pulse, size: str) -> None:
    """Nothing to scroll for on a bridge, nothing cut off at the side of a phone, units on every number."""
    width, height = SIZES[size]
    page.set_viewport_size({"width": width, "height": height})
    say(pulse, page, "Alarm", forecast(60.0, 14.0), conditions=URGENT)
    wide, high = page.evaluate("[document.documentElement.scrollWidth, document.documentElement.scrollHeight]")
    assert wide == width
    assert size == "phone" or high == height
    inside = "name => [...document.querySelectorAll(name)].every(one => one.scrollHeight <= one.clientHeight)"
    assert page.evaluate(inside, ".readout, .alerts")
    said = {
        "headline": URGENT[BANK].text, "caveats": "Beyond the data: speed 4.2 m/s.", "chance": "14 s",
        "contact": "60 s", "contact-side": "to starboard", "nobody": "100 %", "rudder": "S 6°",
        "escape": "Hard to port, then steady parallel to the bank", "leaves": ": keeps 21 m clear",
        "bow-port": "200 m", "bow-starboard": "68 m", "stern-starboard": "80 m", "bow-starboard-speed": "▼ 0.3 m/s",
        "speed": "8.2 kn", "turn": "S 3.4°/min",
    }  # fmt: skip
    assert {name: page.inner_text(f"#{name}") for name in said} == said
    for name in ("#headline", "#caveats", "#chance", "#escape", "[data-command=acknowledge]"):
        box = page.locator(name).first.bounding_box()
        assert 0 <= box["x"]
        assert box["x"] + box["width"] <= width
        assert box["y"] + box["height"] <= (height if size != "phone" else 844)


def test_the_keyboard_acknowledges_and_the_focus_goes_on(page: Any, pulse: Pulse) -> None:
    """Tab, Enter: as the bridge's own sentence; what is to be read aloud is in a region that is read aloud."""
    say(pulse, page, "Alarm", forecast(60.0, 14.0), conditions=ALARM)
    assert page.get_attribute("#spoken", "role") == "alert"
    assert page.text_content("#spoken") == f"Alarm: {ALARM[BANK].text}"
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.ariaLabel") == "Acknowledge: BANK TO STBD"
    page.keyboard.press("Enter")
    (alert,) = soon(lambda: asked(pulse.page, pulse.monitored))
    assert alert.state.value == "acknowledged"
    pulse.status = pulse.monitored.status(forecast(60.0, 14.0), conditions=ALARM)
    page.wait_for_selector("#alerts li[data-state=acknowledged]")
    assert page.inner_text(".state") == "Alarm, acknowledged"
    assert page.evaluate("document.activeElement.id") == "alerts-title"
    assert page.get_attribute("html", "data-sounding") is None


def test_a_key_silences_and_a_refusal_is_read(page: Any, pulse: Pulse) -> None:
    say(pulse, page, "Alarm", forecast(60.0, 14.0), conditions=ALARM)
    page.keyboard.press("s")
    assert [alert.state.value for alert in soon(lambda: asked(pulse.page, pulse.monitored))] == ["silenced"]
    page.keyboard.press("a")  # As it was seen before it was silenced.
    soon(lambda: not pulse.page.requests._waiting.empty())
    assert asked(pulse.page, pulse.monitored) == []
    page.wait_for_selector("#refused:not(:empty)")
    assert page.inner_text("#refused").startswith("Refused. That alert is over, or has changed")
    assert page.get_attribute("#refused", "role") == "status"


def test_what_is_not_available_is_never_green(page: Any, pulse: Pulse) -> None:
    clear = page.evaluate("getComputedStyle(document.querySelector('h1')).color")
    silent = {NO_FORECAST: Condition(Priority.WARNING, "no heading for 11 s")}
    say(pulse, page, "Not available", now=None, conditions=silent)
    assert page.evaluate("getComputedStyle(document.querySelector('h1')).color") != clear
    assert background(page) == "rgb(91, 102, 112)"
    assert page.inner_text("#chance") == page.inner_text("#bow-port") == "–"
    assert page.is_visible("#nowhere")
    assert "No heading for 11 s" in page.inner_text("#alerts").replace("no heading", "No heading")


def test_what_is_old_is_covered_and_comes_back(page: Any, pulse: Pulse) -> None:
    assert not page.is_visible("#stale")
    pulse.beats = False
    page.wait_for_timeout(1500)
    assert not page.is_visible("#stale")
    page.wait_for_selector("#stale", timeout=2000)
    assert page.inner_text("#stale-words") == "Since 2 s. Nothing on this page can be believed."
    assert page.title() == "No update · narrows monitor"
    pulse.beats = True
    page.wait_for_selector("#stale", state="hidden")


def test_the_palette_is_kept(page: Any) -> None:
    """Each by its button; the one that was chosen is there when the page is opened again."""
    seen = set()
    for palette in ("day", "dusk", "night"):
        page.check(f"input[value={palette}]", force=True)
        seen.add(page.evaluate("getComputedStyle(document.documentElement).backgroundColor"))
    assert len(seen) == 3
    page.reload()
    assert page.get_attribute("html", "data-palette") == "night"
    page.check("input[value=day]", force=True)


def test_a_wrong_token_is_told_in_words(shown: Any, browser: Any, pulse: Pulse) -> None:
    other = browser.new_page()
    other.goto(pulse.address[:-3])
    assert other.inner_text("body").startswith("The token is missing or wrong")
    other.close()
