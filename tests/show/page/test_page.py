"""The page in a real browser: it opens, moves the machine, and says what `check` says."""

import importlib.util
import re
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from pipeline.config import Config
from pipeline.config.file import dump_config, load_config
from pipeline.machine import Machine
from tests.cli.calls import invoke
from tests.report.browser import browsing, why_none
from tests.show.page.browsing import Command, Page

WHY_NONE = why_none() or ("" if importlib.util.find_spec("viser") else "viser is not installed")
pytestmark = [pytest.mark.slow, pytest.mark.skipif(bool(WHY_NONE), reason=WHY_NONE or "-")]
WINDOW = {"width": 1120, "height": 460}


@pytest.fixture(scope="module")
def folder(quick_config: Config, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Make a folder with a configuration."""
    path = tmp_path_factory.mktemp("show")
    (path / "quick.yaml").write_text(dump_config(quick_config))
    return path


@pytest.fixture(scope="module")
def command(folder: Path) -> Iterator[Command]:
    """Run the command; the last test ends it."""
    started = Command("quick.yaml", folder=folder)
    yield started
    started.process.kill()
    started.process.wait()


@pytest.fixture(scope="module")
def page(command: Command) -> Iterator[Page]:
    """Open the page."""
    with browsing() as browser:
        yield Page(browser, command.address, WINDOW)


def picture(page: Page) -> np.ndarray:
    """Take a picture of the scene."""
    return np.asarray(Image.open(BytesIO(page.page.locator("canvas").first.screenshot())).convert("RGB")).astype(int)


def test_it_opens_and_a_slider_moves_the_machine(page: Page, command: Command) -> None:
    """The page draws, asks for nothing from elsewhere, and the machine follows a slider that is dragged."""
    assert re.fullmatch(r"http://127\.0\.0\.1:\d+", command.address)
    before = page.pose()
    assert before == [1.02, 0.3, 0.9]
    thumb = page.page.locator("[role=slider]").first.bounding_box()
    place = thumb["x"] + thumb["width"] / 2.0, thumb["y"] + thumb["height"] / 2.0
    page.drag(place, (place[0] + 12.0, place[1]))
    after = page.wait_for_move(before)
    assert after[0] > before[0]
    assert after[1:] == before[1:]
    assert len(np.unique(picture(page).reshape(-1, 3), axis=0)) > 100
    assert page.complaints == []
    assert all(url.startswith((command.address, "blob:", "data:")) for url in page.requests)


def test_the_tool_moves_the_machine(page: Page, machine: Machine) -> None:
    """An arrow of the gizmo that is dragged takes the machine along its axis."""
    before = page.pose()
    grip, there = (np.array(before) + [distance, 0.0, 0.0] for distance in (0.2, 0.35))
    page.drag(page.place_of(grip, machine), page.place_of(there, machine))
    after = page.wait_for_move(before)
    assert after[0] == pytest.approx(before[0] + 0.15, abs=0.08)
    assert after[1:] == before[1:]


def test_numbers_are_those_of_check(page: Page, folder: Path) -> None:
    """The saved file has the pose, `check` accepts it, and its table has the same numbers for the start."""
    page.tab("Task")
    page.press("Start here")
    page.wait_for("start")
    shown = page.readings()
    page.tab("Plan")
    page.fill(0, "mine.yaml")
    page.press("Save")
    page.wait_for("saved: mine.yaml")
    start = load_config(folder / "mine.yaml").task.start
    assert [start.x_m, start.y_m, start.z_m] == page.pose()
    result = invoke("check", folder / "mine.yaml")
    assert result.exit_code == 0
    rows = [[cell.strip() for cell in line.strip("│ ").split("│")] for line in result.stdout.splitlines()]
    checked = {row[0]: row[2] for row in rows if len(row) == 5}
    for actuator in ("c1", "c2", "c3", "l2b", "l3b"):
        assert shown[actuator][0] == f"{checked[actuator]} m"
    assert round(float(shown["kappa"][0]), 3) == float(checked["kappa"])
    (distance,) = (value for limit, (value, _, _) in shown.items() if limit.startswith("link-link distance"))
    assert distance == f"{checked['least link-link distance']} m"
    assert shown["holding force"][0] == f"{checked['holding force']} of allowed"
    assert shown["least link-rail distance"][0] == f"{checked['least link-rail distance']} m"


def test_a_pose_out_of_reach_is_refused_as_by_check(page: Page) -> None:
    """The machine stays where it was, red, with the reason; nothing is overwritten unasked."""
    page.tab("Jog")
    before = page.pose()
    page.fill(1, "1.25")
    page.wait_for("Out of reach.")
    assert "is out of reach for arm" in page.text()
    assert page.pose() == before
    page.tab("Plan")
    page.press("Save")
    page.wait_for("mine.yaml is there already")


def test_ctrl_c_ends_it(command: Command) -> None:
    """The exit code is 0, and nothing is complained of."""
    code, output, errors = command.end()
    assert (code, errors) == (0, "")
    assert output.endswith("ended\n")
