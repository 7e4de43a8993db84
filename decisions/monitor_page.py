"""The monitor's page as a bridge sees it: screenshots of the demonstration in a browser without a screen.

python decisions/monitor_page.py FOLDER    # pictures of all moments, sizes and palettes
python decisions/monitor_page.py FILE.gif  # the README's film

`make docs` draws its figure; all need Playwright and a Chromium.
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
from PIL import Image

from narrows.warning.monitoring.bridge_monitor import BridgeMonitor
from narrows.warning.monitoring.demonstration import LINE, demonstration
from narrows.warning.page.bridge_page import BridgePage, update_of

SIZES = {"desktop": (1440, 900), "panel": (1280, 800), "old": (1024, 768), "phone": (390, 844)}
PALETTES = ("day", "dusk", "night")
MOMENTS = ("watch", "caution", "warning", "alarm", "emergency alarm")
"""Of the demonstration, by the status that the page has some seconds after it came."""
HELD, USUAL_SPEED, SETTLED, DPI = 2, 4.0, 400, 110
# Of the film: seconds of the demonstration and milliseconds of film a frame, and its width in pixels.
STEP, SHOWN, FILM_WIDTH = 6, 350, 720


def figure() -> Figure:
    """The bridge panel by day, at the alarm."""
    width, height = SIZES["panel"]
    drawn = Figure(figsize=(width / DPI, height / DPI))
    axes = drawn.add_axes((0, 0, 1, 1))
    axes.axis("off")
    try:
        with pages() as shown:
            axes.imshow(matplotlib.image.imread(io.BytesIO(shown(moments()["alarm"], "panel", "day"))))
    except (ImportError, StopIteration):
        axes.text(0.5, 0.5, "drawn where there are Playwright and Chromium", ha="center")
    return drawn


@contextmanager
def pages() -> Iterator[Any]:
    """What gives the page that is told an update, in a size and a palette, as PNG."""
    from playwright.sync_api import sync_playwright

    path = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))))
    page = BridgePage()
    with page.open() as address, sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=path, args=["--no-sandbox", "--disable-dev-shm-usage"])

        def shown(update: dict[str, Any], size: str, palette: str) -> bytes:
            width, height = SIZES[size]
            tab = browser.new_page(viewport={"width": width, "height": height}, reduced_motion="reduce")
            tab.add_init_script(f"localStorage.setItem('narrows-palette', '{palette}')")
            tab.goto(address)
            while tab.locator("html[data-stale]").count():
                page.send(update)
                tab.wait_for_timeout(SETTLED)
            tab.wait_for_timeout(SETTLED)
            picture = tab.screenshot(full_page=size == "phone")
            tab.close()
            return picture

        yield shown
        browser.close()


def updates() -> Iterator[tuple[str, dict[str, Any]]]:
    """Status of each second of the demonstration, and what the page is told."""
    shown = demonstration()
    watched = BridgeMonitor(shown.model, shown.waterway, LINE)
    watched.prepare(USUAL_SPEED)
    for tick in shown.ticks():
        status = watched.update(tick, tick.t)
        yield status.word, update_of(watched, status, tick.t)


def moments() -> dict[str, Any]:
    """What the page is told at the moments of the demonstration."""
    told, seconds = {}, Counter[str]()
    for word, update in updates():
        seconds[word] += 1
        if seconds[word] == HELD:
            told[word] = update
        if set(told) >= set(MOMENTS):
            break
    return told


def film(path: Path) -> None:
    """The page from the first watch to the emergency alarm."""
    told = list(updates())
    words = [word for word, _ in told]
    seconds = range(words.index(MOMENTS[0]), words.index(MOMENTS[-1]) + 2 * STEP, STEP)
    with pages() as shown:
        drawn = [Image.open(io.BytesIO(shown(told[second][1], "panel", "day"))).convert("RGB") for second in seconds]
    height = round(FILM_WIDTH * drawn[0].height / drawn[0].width)
    frames = [frame.resize((FILM_WIDTH, height)).quantize(64) for frame in drawn]
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=SHOWN, loop=0, optimize=True)


if __name__ == "__main__":
    written = Path(sys.argv[1])
    if written.suffix == ".gif":
        film(written)
    else:
        written.mkdir(exist_ok=True)
        with pages() as shown:
            for (moment, update), size, palette in product(moments().items(), SIZES, PALETTES):
                (written / f"{moment}-{size}-{palette}.png").write_bytes(shown(update, size, palette))
