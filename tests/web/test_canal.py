"""The canal drawing, held to geometry: in a real browser, by the pixels that it leaves."""

import math
from collections.abc import Iterator
from typing import Any

import pytest

from browsers import chromium
from narrows.web import asset, without_exports

SIZE = {"width": 400, "height": 300}
BANKS = [[[-500, -100], [500, -100]], [[-500, 100], [500, 100]]]
COLOURS = {"land": "rgb(200, 0, 0)", "water": "rgb(0, 0, 200)", "bank": "rgb(0, 0, 0)", "hull": "rgb(0, 200, 0)"}
LAND, WATER, HULL = [200, 0, 0], [0, 0, 200], [0, 200, 0]
PIXEL = "(x, y) => [...canvas.getContext('2d').getImageData(x, y, 1, 1).data].slice(0, 3)"


@pytest.fixture(scope="module")
def page() -> Iterator[Any]:
    with chromium() as browser:
        page = browser.new_page(viewport=SIZE)
        page.set_content("<body style='margin:0'><canvas style='width:400px;height:300px;display:block'></canvas>")
        page.evaluate(f"{without_exports(asset('canal.js'))}; Object.assign(globalThis, {{canalView, canalColours}})")
        page.evaluate(
            "colours => { canvas = document.querySelector('canvas'); view = canalView(canvas, colours) }", COLOURS
        )
        yield page


def look(page: Any, **wanted: float) -> None:
    page.evaluate("wanted => view.look(wanted)", {"along": 0, "across": 0, "metresPerPixel": 1, "heading": 0, **wanted})


def pixel(page: Any, x: float, y: float) -> list[int]:
    return page.evaluate(f"([x, y]) => ({PIXEL})(x, y)", [x, y])


@pytest.mark.parametrize(("heading", "place"), [(0.0, [50.0, 30.0]), (math.pi / 2, [-30.0, 50.0])])
def test_ahead_is_up_and_starboard_right(page: Any, heading: float, place: list[float]) -> None:
    look(page, heading=heading)
    assert page.evaluate("view.toMetres(200 + 30, 150 - 50)") == pytest.approx(place, abs=1e-9)


def test_pixels_and_metres_are_inverse(page: Any) -> None:
    look(page, along=700.0, across=-20.0, metresPerPixel=2.5, heading=0.4, down=0.7)
    there_and_back = page.evaluate("view.toMetres(...view.toPixels([812.5, 33]))")
    look(page, down=0.5)
    assert there_and_back == pytest.approx([812.5, 33.0])


def test_water_ends_at_the_banks(page: Any) -> None:
    look(page)
    page.evaluate("banks => view.water(banks)", BANKS)
    assert [pixel(page, 200 + off, 150) for off in (-105, -95, 95, 105)] == [LAND, WATER, WATER, LAND]


def test_a_ship_is_drawn_to_scale(page: Any) -> None:
    look(page, metresPerPixel=2)
    page.evaluate("banks => view.water(banks)", BANKS)
    page.evaluate("view.ship({along: 0, across: 0, heading: 0}, {length: 230, beam: 32}, {fill: 'hull'})")
    # Half its length up and down, half its beam to both sides.
    assert [pixel(page, 200, 150 + off) for off in (-59, -54, 55, 59)] == [WATER, HULL, HULL, WATER]
    assert [pixel(page, 200 + off, 150) for off in (-10, -7, 6, 10)] == [WATER, HULL, HULL, WATER]


def test_every_colour_is_in_every_palette(page: Any) -> None:
    page.add_style_tag(content=asset("palette.css"))
    for palette in ("day", "dusk", "night"):
        page.evaluate("name => { document.documentElement.dataset.palette = name }", palette)
        colours = page.evaluate("canalColours(document.documentElement)")
        assert len(colours) == 8
        assert all(colour.startswith("#") for colour in colours.values())


def test_a_script_that_is_set_in_exports_nothing() -> None:
    assert "export function canalView" in asset("canal.js")
    assert "\nexport " not in without_exports(asset("canal.js"))
    assert "import " not in without_exports(asset("canal.js")).replace("// ", "")
