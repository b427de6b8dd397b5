"""A real browser for the tests of the report: the system's own, without a screen."""

import importlib.util
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
ARGUMENTS = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
    # 3-D without a graphics card.
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
)


def find_browser() -> str | None:
    """Find the system's browser; None where there is none."""
    return next((path for name in NAMES if (path := shutil.which(name))), None)


def why_none() -> str:
    """Say why there can be no test in a browser; nothing where there can."""
    if importlib.util.find_spec("playwright") is None:
        return "Playwright is not installed"
    if find_browser() is None:
        return f"there is no browser: none of {', '.join(NAMES)} (apt-get install chromium)"
    return ""


@contextmanager
def browsing() -> Iterator[Any]:
    """Start the browser, and close it in the end."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=find_browser(), args=list(ARGUMENTS))
        yield started
        started.close()
