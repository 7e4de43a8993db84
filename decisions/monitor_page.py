"""The monitor's page as a bridge sees it: screenshots of the demonstration in a browser without a screen.

python decisions/monitor_page.py FOLDER

`make docs` draws its figure; both need Playwright and a Chromium.
"""

import io
import shutil
import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import product
from pathlib import Path
from typing import Any

import matplotlib.image
from matplotlib.figure import Figure

from narrows.warning.monitoring.bridge_monitor import BridgeMonitor
from narrows.warning.monitoring.demonstration import LINE, demonstration
from narrows.warning.page.bridge_page import BridgePage
from narrows.warning.page.page_updates import packed, update_of

SIZES = {"desktop": (1440, 900), "panel": (1280, 800), "old": (1024, 768), "phone": (390, 844)}
PALETTES = ("day", "dusk", "night")
MOMENTS = ("watch", "caution", "warning", "alarm", "emergency alarm")
"""Of the demonstration, by the status that the page has some seconds after it came."""
HELD, USUAL_SPEED, SETTLED, DPI = 2, 4.0, 400, 110


def figure() -> Figure:
    """The bridge panel by day, at the alarm."""
    width, height = SIZES["panel"]
    drawn = Figure(figsize=(width / DPI, height / DPI))
    axes = drawn.add_axes((0, 0, 1, 1))
    axes.axis("off")
    try:
        with pages() as shown:
            axes.imshow(matplotlib.image.imread(io.BytesIO(shown("alarm", "panel", "day"))))
    except (ImportError, StopIteration):
        axes.text(0.5, 0.5, "drawn where there are Playwright and Chromium", ha="center")
    return drawn


@contextmanager
def pages() -> Iterator[Any]:
    """What gives the page at a moment, in a size and a palette, as PNG."""
    from playwright.sync_api import sync_playwright

    path = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))))
    page, told = BridgePage(), updates()
    with page.open() as address, sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=path, args=["--no-sandbox", "--disable-dev-shm-usage"])

        def shown(moment: str, size: str, palette: str) -> bytes:
            width, height = SIZES[size]
            tab = browser.new_page(viewport={"width": width, "height": height}, reduced_motion="reduce")
            tab.add_init_script(f"localStorage.setItem('narrows-palette', '{palette}')")
            page.updates.publish(told[moment])
            tab.goto(address)
            tab.wait_for_selector("html:not([data-stale])")
            tab.wait_for_timeout(SETTLED)
            picture = tab.screenshot(full_page=size == "phone")
            tab.close()
            return picture

        yield shown
        browser.close()


def updates() -> dict[str, str]:
    """What the page is told at the moments of the demonstration."""
    shown, told, seconds = demonstration(), {}, Counter[str]()
    watched = BridgeMonitor(shown.model, shown.waterway, LINE)
    watched.prepare(USUAL_SPEED)
    for tick in shown.ticks():
        status = watched.update(tick, tick.t)
        seconds[status.word] += 1
        if seconds[status.word] == HELD:
            told[status.word] = packed(update_of(watched, status, tick.t))
        if set(told) >= set(MOMENTS):
            break
    return told


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    folder.mkdir(exist_ok=True)
    with pages() as shown:
        for moment, size, palette in product(MOMENTS, SIZES, PALETTES):
            (folder / f"{moment}-{size}-{palette}.png").write_bytes(shown(moment, size, palette))
