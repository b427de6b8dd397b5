"""The page in a real browser: it draws, moves, answers mouse and keys, fits a phone, and loads nothing else."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pipeline.report import Report, RunResults, build_report, render_page
from pipeline.report.palette import LIGHT
from pipeline.stage import Stage
from tests.report.browser import why_none
from tests.report.opened import DESKTOP, PHONE, Opened

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(bool(why_none()), reason=why_none() or "-"),
]

FIXED_LINKS, TELESCOPES, CARTS = 3, 4, 7
FRAME = "() => Number(document.getElementById('time').value)"
CURSOR = "() => document.getElementById('cursor').getBoundingClientRect().x"
POINT = "() => { const b = document.getElementById('point').getBoundingClientRect(); return [b.x, b.y]; }"
AXIS = """
() => {
  const plot = document.getElementById('timeline');
  return [plot.layout.margin.l, plot.layout.margin.r, plot.getBoundingClientRect().width];
}
"""
LONGEST = "() => document.getElementById('timeline').layout.xaxis.range[1]"
OVERLAPS = """
() => {
  const boxes = [...document.querySelectorAll('main > section > *, .stage > *, .verdicts > li, header > *')]
    .filter(e => e.offsetParent && getComputedStyle(e).position !== 'sticky').map(e => [e, e.getBoundingClientRect()]);
  const cut = (a, b) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1
    && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 1;
  const found = [];
  for (const [a, boxA] of boxes) for (const [b, boxB] of boxes)
    if (a !== b && !a.contains(b) && !b.contains(a) && cut(boxA, boxB)) found.push(a.outerHTML.slice(0, 60));
  return found;
}
"""


@pytest.fixture(autouse=True)
def at_start(request: pytest.FixtureRequest) -> None:
    """Begin every test on the desktop at the first instant of the refined motion, nothing in focus."""
    if "desk" in request.fixturenames:
        desk = request.getfixturevalue("desk")
        desk.page.evaluate("document.activeElement.blur()")
        desk.page.locator("input[value=refined]").check()
        desk.page.locator("#speed").select_option("1")
        desk.page.evaluate("document.activeElement.blur()")
        desk.go_to(0)


def test_it_loads_quietly(desk: Opened, record_property: Any) -> None:
    """There is no error on the console, and the only thing asked for is the file; the first paint is told."""
    assert desk.complaints() == []
    assert [url for url in desk.requests if not url.startswith(("data:", "blob:"))] == [desk.page.url]
    paints = desk.page.evaluate("() => performance.getEntriesByType('paint').map(e => [e.name, e.startTime])")
    first = dict(paints)["first-contentful-paint"]
    record_property("first_contentful_paint_ms", first)
    print(f"first contentful paint after {first:.0f} ms")  # noqa: T201 - told, not asserted tightly: machines differ
    assert first < 10_000.0


def test_play_moves_the_machine(desk: Opened) -> None:
    """Playing moves links and carts, pausing stops them."""
    before, cursor = desk.trace(FIXED_LINKS), desk.page.evaluate(CURSOR)
    # Slowly, so that it is not at its end before it is paused.
    desk.page.locator("#speed").select_option("0.1")
    desk.page.locator("#play").click()
    assert desk.page.locator("#play").inner_text() == "Pause"
    desk.page.wait_for_function("() => Number(document.getElementById('time').value) > 5")
    desk.page.locator("#play").click()
    desk.settle()
    stopped = desk.trace(FIXED_LINKS)
    assert np.nanmax(np.abs(stopped - before)) > 1e-4
    assert desk.page.evaluate(CURSOR) > cursor
    desk.settle()
    assert np.array_equal(desk.trace(FIXED_LINKS), stopped, equal_nan=True)


def test_playing_ends_at_the_goal(desk: Opened) -> None:
    """At the end it stops, and playing once more begins at the start."""
    last = int(desk.page.locator("#time").get_attribute("max"))
    desk.go_to(last - 3)
    desk.page.locator("#play").click()
    desk.page.wait_for_function("() => document.getElementById('play').textContent === 'Play'")
    assert desk.page.evaluate(FRAME) == last
    desk.page.locator("#speed").select_option("0.1")
    desk.page.locator("#play").click()
    desk.page.wait_for_function(f"() => Number(document.getElementById('time').value) < {last // 2}")
    desk.page.locator("#play").click()


def test_scrubbing_moves_everything_together(desk: Opened) -> None:
    """Machine, cursor, point on the map, title of the map and values follow the slider."""
    seen = []
    for frame in (0, 50, 100):
        desk.go_to(frame)
        seen.append(
            (
                desk.page.evaluate(CURSOR),
                desk.page.evaluate(POINT),
                desk.page.locator("#map-title").inner_text(),
                desk.page.locator("#readout").inner_text(),
                desk.page.locator("#time-text").inner_text(),
            )
        )
    cursors, points, titles, values, times = zip(*seen, strict=True)
    assert cursors[1] - cursors[0] == pytest.approx(cursors[2] - cursors[1], abs=1.5)
    assert cursors[0] < cursors[1]
    assert len({tuple(point) for point in points}) == len(set(titles)) == len(set(values)) == 3
    assert times == ("0.00 / 2.00 s", "1.00 / 2.00 s", "2.00 / 2.00 s")


def test_links_on_the_page_have_their_lengths(desk: Opened, machine: Any) -> None:
    """What is drawn is the machine: the lengths of fixed links come back from the trace."""
    desk.go_to(70)
    ends = desk.trace(FIXED_LINKS).T.reshape(-1, 3, 3)
    lengths = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)
    assert np.allclose(lengths, machine.lengths_m[~np.isnan(machine.lengths_m)], atol=1e-5)


def test_hovering_shows_numbers(desk: Opened) -> None:
    """Over the curves and over the map there are values with units."""
    for plot, place, wanted in (
        ("#timeline", (0.4, 0.2), "x 1."),
        ("#timeline", (0.4, 0.8), "m/s"),
        ("#map", (0.5, 0.4), "κ"),
    ):
        desk.point_at(*desk.place(plot, *place))
        desk.page.wait_for_selector(f"{plot} .hoverlayer text", timeout=20_000)
        text = " ".join(desk.page.locator(f"{plot} .hoverlayer text").all_text_contents())
        assert wanted in text
        assert any(letter.isdigit() for letter in text)


def test_a_click_into_a_plot_goes_there(desk: Opened) -> None:
    """Clicking where the time axis has a second and a half goes to that time."""
    start, end, width = desk.page.evaluate(AXIS)
    x, y = desk.place("#timeline", 0.0, 0.5)
    x += start + (width - start - end) * 1.5 / desk.page.evaluate(LONGEST)
    desk.point_at(x, y)
    desk.page.wait_for_selector("#timeline .hoverlayer text", timeout=20_000)
    desk.page.mouse.click(x, y)
    desk.settle()
    assert float(desk.page.locator("#time-text").inner_text().split()[0]) == pytest.approx(1.5, abs=0.05)


def test_keys(desk: Opened) -> None:
    """Within the motion Space plays, arrows step, Home and End go to the ends, digits choose a view, C the path."""
    desk.page.locator("#motion").focus()
    keyboard, last = desk.page.keyboard, int(desk.page.locator("#time").get_attribute("max"))
    steps = (
        ("ArrowRight", 1),
        ("Shift+ArrowRight", 11),
        ("ArrowLeft", 10),
        ("End", last),
        ("ArrowRight", last),
        ("Home", 0),
    )
    for key, frame in steps:
        keyboard.press(key)
        assert desk.page.evaluate(FRAME) == frame, key
    desk.page.locator("#speed").select_option("0.1")
    desk.page.locator("#motion").focus()
    keyboard.press("Space")
    assert desk.page.locator("#play").inner_text() == "Pause"
    keyboard.press("Space")
    assert desk.page.locator("#play").inner_text() == "Play"
    eye = "() => document.getElementById('machine').layout.scene.camera.eye.z"
    before = desk.page.evaluate(eye)
    keyboard.press("4")
    desk.settle()
    assert desk.page.evaluate(eye) > before
    assert desk.page.locator("#cameras button[aria-pressed=true]").inner_text() == "Top"
    keyboard.press("1")
    keyboard.press("c")
    assert desk.page.locator("input[value=coarse]").is_checked()


def test_everything_is_reached_by_tab(desk: Opened) -> None:
    """Tab goes through play, time, path, speed and views, and whatever has the focus shows it."""
    desk.page.locator("#play").focus()
    reached = []
    for _ in range(9):
        reached.append(
            desk.page.evaluate(
                "() => document.activeElement.id || document.activeElement.value || document.activeElement.textContent"
            )
        )
        desk.page.keyboard.press("Tab")
    assert reached[:4] == ["play", "time", "refined", "speed"]
    assert {"Overview", "Front", "Side", "Top"} <= set(reached)
    desk.page.locator("#time").focus()
    desk.page.keyboard.press("ArrowRight")
    outline = desk.page.evaluate("() => getComputedStyle(document.activeElement).outlineStyle")
    assert outline == "solid"
    assert desk.page.evaluate(FRAME) == 1


def test_coarse_and_refined(desk: Opened) -> None:
    """The other path moves otherwise, at the same part of its own duration."""
    desk.go_to(50)
    refined, text = desk.trace(CARTS), desk.page.locator("#time-text").inner_text()
    desk.page.locator("input[value=coarse]").check()
    desk.settle()
    assert desk.page.locator("#time-text").inner_text() != text
    assert np.nanmax(np.abs(desk.trace(CARTS) - refined)) > 1e-5
    part, whole = desk.page.evaluate(
        "() => [document.getElementById('time').value, document.getElementById('time').max]"
    )
    assert float(part) / float(whole) == pytest.approx(0.5, abs=0.01)


def near(picture: np.ndarray, colour: str) -> np.ndarray:
    """Tell which pixels nearly have a colour, in the light of the scene. Shape (height, width)."""
    wanted = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)])
    return np.abs(picture - wanted).max(axis=2) < 40


def test_two_pictures_of_the_machine(desk: Opened) -> None:
    """At start and goal there are links of both kinds, carts and rails, in other places against the same ground."""
    first = desk.picture("#machine")
    desk.go_to(int(desk.page.locator("#time").get_attribute("max")))
    last = desk.picture("#machine")
    assert first.shape == last.shape
    for picture in (first, last):
        for colour in (LIGHT.first, LIGHT.second, LIGHT.third, LIGHT.rail):
            assert near(picture, colour).sum() > 20, colour
    changed = np.abs(first - last).max(axis=2) > 30
    assert 0.0005 < changed.mean() < 0.2
    # Nothing touches the rim: the whole machine is in the picture.
    links = near(first, LIGHT.first) | near(last, LIGHT.first)
    assert not links[:3].any()
    assert not links[-3:].any()
    assert not links[:, :3].any()
    assert not links[:, -3:].any()


def test_nothing_overlaps_on_a_desktop(desk: Opened) -> None:
    """No part of the page covers another one, none is empty, and nothing is wider than the window."""
    assert desk.page.evaluate(OVERLAPS) == []
    assert desk.page.evaluate("() => document.documentElement.scrollWidth") <= DESKTOP["width"]
    for plot in ("#machine", "#map", "#timeline", "#proof"):
        assert desk.picture(plot).std() > 5.0, f"{plot} is empty"


def test_on_a_phone(browser: Any, file: Path) -> None:
    """On a narrow screen the page is as wide as it, plots have their size, and touching plays."""
    phone = Opened(browser, file, PHONE, touch=True)
    assert phone.page.evaluate("() => document.documentElement.scrollWidth") == PHONE["width"]
    assert phone.page.evaluate(OVERLAPS) == []
    for plot in ("#machine", "#map", "#timeline", "#proof"):
        box = phone.page.locator(plot).bounding_box()
        assert box["width"] > 340
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= PHONE["width"]
    phone.page.locator("#play").tap()
    phone.page.wait_for_function("() => Number(document.getElementById('time').value) > 2")
    assert phone.complaints() == []
    phone.page.close()


def test_a_proof_without_motion(
    browser: Any,
    complete: RunResults,
    failed_at: Callable[[RunResults, Stage], RunResults],
    tmp_path: Path,
) -> None:
    """Where the path could not be timed, the proof is still drawn, and nothing complains."""
    file = tmp_path / "failed.html"
    file.write_text(render_page(build_report(failed_at(complete, Stage.RETIME))), encoding="utf-8")
    opened = Opened(browser, file, DESKTOP)
    assert opened.complaints() == []
    assert opened.picture("#proof").std() > 5.0
    opened.page.close()


def test_without_a_coarse_motion(browser: Any, report: Report, tmp_path: Path) -> None:
    """Where the coarse path could not be driven, there is one path to choose, and it plays."""
    file = tmp_path / "refined.html"
    file.write_text(render_page(replace(report, motions=report.motions[:1])), encoding="utf-8")
    opened = Opened(browser, file, DESKTOP)
    assert opened.page.locator("#paths input").count() == 1
    opened.page.locator("#motion").focus()
    opened.page.keyboard.press("c")
    opened.page.keyboard.press("End")
    opened.settle()
    assert opened.complaints() == []
    opened.page.close()
