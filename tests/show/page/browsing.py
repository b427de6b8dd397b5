"""The page in a browser, as tests and the picture of the documentation use it."""

import os
import re
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.machine import Machine
from pipeline.show.page.scene import camera_of

PROJECT = Path(__file__).parents[3]
PATIENCE_MS = 180_000
_CELLS = """
() => [...document.querySelectorAll('.gantry-readings tr')].slice(1).map(row => [...row.cells].map(c => c.innerText))
"""
_FOV_RAD = np.deg2rad(75.0)


class Command:
    """`gantry-tau show` in a process of its own."""

    def __init__(self, *arguments: object, folder: Path) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", "pipeline", "show", *map(str, arguments), "--no-browser"],
            env={**os.environ, "PYTHONPATH": str(PROJECT), "OPENBLAS_NUM_THREADS": "1"},
            cwd=folder,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        assert self.process.stdout is not None
        self.address = self.process.stdout.readline().strip()

    def end(self) -> tuple[int, str, str]:
        """Press Ctrl-C; give the exit code and what was printed."""
        self.process.send_signal(signal.SIGINT)
        output, errors = self.process.communicate(timeout=60.0)
        return self.process.returncode, output, errors


class Page:
    """The page, with what it complained of and asked for."""

    def __init__(self, browser: Any, address: str, viewport: dict[str, int]) -> None:
        self.complaints: list[str] = []
        self.requests: list[str] = []
        self.page = browser.new_page(viewport=viewport)
        self.page.set_default_timeout(PATIENCE_MS)
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.goto(address)
        self.page.wait_for_selector(".gantry-readings")
        self.page.wait_for_selector("[role=slider]")

    def tab(self, name: str) -> None:
        """Go to a tab."""
        self.page.locator("[role=tab]", has_text=name).click()

    def press(self, button: str) -> None:
        """Press a button."""
        self.page.get_by_role("button", name=button, exact=True).click()

    def fill(self, number: int, value: str) -> None:
        """Type a value into a field of the tab, counted from 0."""
        field = self.page.locator("input:visible:not([type=checkbox])").nth(number)
        field.fill(value)
        field.press("Enter")

    def text(self) -> str:
        """Give all that is written."""
        return str(self.page.locator("body").inner_text())

    def wait_for(self, text: str) -> None:
        """Wait until something is written."""
        self.page.wait_for_function("text => document.body.innerText.includes(text)", arg=text)

    def pose(self) -> list[float]:
        """Read x, y, z of the machine."""
        return [float(found) for found in re.search(r"x (\S+), y (\S+), z (\S+) m; rx", self.text()).groups()]

    def wait_for_move(self, before: list[float]) -> list[float]:
        """Wait until the machine is elsewhere; give the place."""
        start = "x {:.4f}, y {:.4f}, z {:.4f} m; rx".format(*before)
        self.page.wait_for_function("text => !document.body.innerText.includes(text)", arg=start)
        self.page.wait_for_timeout(300)
        return self.pose()

    def readings(self) -> dict[str, tuple[str, str, str]]:
        """Read the table of limits: value, what is allowed, and margin."""
        cells = self.page.evaluate(_CELLS)
        return {name: (value, allowed, margin) for name, value, allowed, margin, _ in cells}

    def drag(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        """Drag with the mouse; slow drawing must not lose the grip."""
        mouse = self.page.mouse
        mouse.move(*start)
        self.page.wait_for_timeout(500)
        mouse.down()
        mouse.move(*end, steps=3)
        mouse.up()

    def place_of(self, point: Any, machine: Machine) -> tuple[float, float]:
        """Project a point of space to the window, as the camera does that nobody has moved yet."""
        box = self.page.locator("canvas").first.bounding_box()
        position, seen = camera_of(machine)
        forward = (seen - position) / np.linalg.norm(seen - position)
        right = np.cross(forward, [0.0, 0.0, 1.0])
        right /= np.linalg.norm(right)
        up, line = np.cross(right, forward), np.asarray(point) - position
        scale = box["height"] / 2.0 / np.tan(_FOV_RAD / 2.0) / float(line @ forward)
        across, down = float(line @ right) * scale, -float(line @ up) * scale
        return box["x"] + box["width"] / 2.0 + across, box["y"] + box["height"] / 2.0 + down
