"""A page in a browser: what it complains of and asks for, and how a person would use it."""

from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

DESKTOP = {"width": 1280, "height": 900}
PHONE = {"width": 390, "height": 844}
_TRACE = (
    "k => { const t = document.getElementById('machine').data[k]; return [t.x, t.y, t.z].map(a => Array.from(a)); }"
)
_DRAWN = "() => { const s = document.getElementById('time'); return s.dataset.drawn === s.value; }"
_SCRUB = "f => { const s = document.getElementById('time'); s.value = f; s.dispatchEvent(new Event('input')); }"
_SCROLL = """
([selector, down]) => {
  const box = document.querySelector(selector).getBoundingClientRect();
  scrollTo({ top: scrollY + box.top + down * box.height - innerHeight / 2, behavior: 'instant' });
}
"""
_WATCH = """
window.violations = [];
addEventListener('securitypolicyviolation', e => window.violations.push(`${e.violatedDirective}: ${e.sample}`));
"""


class Opened:
    """The page as it was opened, with what it complained of and asked for."""

    def __init__(
        self, browser: Any, file: Path, viewport: dict[str, int], touch: bool = False, prepare: str = ""
    ) -> None:
        self._complaints: list[str] = []
        self.requests: list[str] = []
        self.page = browser.new_page(viewport=viewport, has_touch=touch, is_mobile=touch)
        self.page.add_init_script(_WATCH + prepare)
        self.page.on("console", lambda message: message.type == "error" and self._complaints.append(message.text))
        self.page.on("pageerror", lambda error: self._complaints.append(str(error)))
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.goto(file.as_uri())
        if self.page.locator("script").count() and not prepare:
            self.page.wait_for_selector("body[data-ready]", timeout=60_000)

    def complaints(self) -> list[str]:
        """Give all errors so far, and all violations of the page's own security policy."""
        return self._complaints + self.page.evaluate("window.violations")

    def go_to(self, frame: int) -> None:
        """Scrub to a frame, and wait until it is drawn."""
        self.page.evaluate(_SCRUB, frame)
        self.settle()

    def settle(self) -> None:
        """Wait until what was wanted last is drawn."""
        self.page.wait_for_function(_DRAWN, timeout=30_000)
        self.page.wait_for_timeout(100)

    def place(self, selector: str, across: float, down: float) -> tuple[float, float]:
        """Scroll to a place of an element, given in parts of its size; return where in the window it is."""
        self.page.evaluate(_SCROLL, [selector, down])
        box = self.page.locator(selector).bounding_box()
        return box["x"] + across * box["width"], box["y"] + down * box["height"]

    def point_at(self, x: float, y: float) -> None:
        """Move the mouse to a place, and a little before."""
        self.page.mouse.move(x - 9, y)
        self.page.mouse.move(x, y)

    def trace(self, number: int) -> np.ndarray:
        """Give x, y, z of a trace of the machine; gaps between lines are NaN."""
        return np.array(self.page.evaluate(_TRACE, number), dtype=float)

    def picture(self, selector: str) -> np.ndarray:
        """Take a picture of an element. Shape (height, width, 3)."""
        return np.asarray(Image.open(BytesIO(self.page.locator(selector).screenshot())).convert("RGB")).astype(int)
