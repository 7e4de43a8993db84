"""A real browser without a screen for the tests of pages; they are skipped where there is none."""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome")
OPTIONS = ["--no-sandbox", "--disable-dev-shm-usage"]
"""Of a container: its root, and its small shared memory."""


@contextmanager
def chromium() -> Iterator[Any]:
    """A browser of this machine, driven by Playwright."""
    playwright = pytest.importorskip("playwright.sync_api", reason="there is no Playwright to drive a browser with")
    path = next(filter(None, map(shutil.which, [os.environ.get("CHROMIUM", ""), *NAMES])), None)
    if path is None:
        pytest.skip("there is no Chromium on this machine")
    with playwright.sync_playwright() as driver:
        try:
            browser = driver.chromium.launch(executable_path=path, args=OPTIONS)
        except playwright.Error as error:
            pytest.skip(f"{path} does not start on this machine: {str(error).splitlines()[0]}")
        yield browser
        browser.close()
