"""The page for everyone: by keyboard, read aloud, in the dark, on a phone, on paper, and in old browsers."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pipeline.report import RunResults, StageFacts, build_report, render_page
from pipeline.report.palette import DARK, LIGHT
from pipeline.stage import Stage
from tests.report.browser import why_none
from tests.report.opened import DESKTOP, PHONE, Opened

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(bool(why_none()), reason=why_none() or "-"),
]

UNFOLD = "() => document.querySelectorAll('details').forEach(one => { one.open = true; })"
FOREIGN = """
() => {
  const script = document.createElement('script');
  script.textContent = 'window.foreign = true';
  const style = document.createElement('style');
  style.textContent = 'body { display: none }';
  document.body.append(script, style);
}
"""
FOCUS = """
() => {
  const { outlineStyle, outlineWidth } = getComputedStyle(document.activeElement);
  const order = [...document.querySelectorAll('*')].indexOf(document.activeElement);
  return [document.activeElement.tagName, order, outlineStyle, parseFloat(outlineWidth)];
}
"""
EYE = "() => { const { x, y, z } = document.getElementById('machine').layout.scene.camera.eye; return [x, y, z]; }"
ON_PAPER = """
() => ({
  folded: document.querySelectorAll('details:not([open])').length,
  widths: ['map', 'timeline', 'proof'].map(id => document.querySelector(`#${id} .main-svg`).clientWidth),
  text: ['map', 'timeline', 'proof'].map(id => document.getElementById(id).layout.font.color),
  still: document.getElementById('machine-still').clientWidth,
})
"""
STILL = """
() => {
  const still = document.getElementById('machine-still');
  const { data } = still.getContext('2d').getImageData(0, 0, still.width, still.height);
  return new Set(new Uint32Array(data.buffer)).size;
}
"""


@pytest.fixture(scope="module")
def failed(
    browser: Any,
    complete: RunResults,
    failed_at: Callable[[RunResults, Stage], RunResults],
    tmp_path_factory: pytest.TempPathFactory,
) -> Iterator[Opened]:
    """Open the page of a run without a path: it has the picture of a route, reasons why not, and no scripts."""
    run = failed_at(complete, Stage.REFINE)
    found = {**run.facts[Stage.REFINE].section, "why_not": ["Reach: 1 of 2", "- more: a route exists"]}
    run = replace(run, facts={**run.facts, Stage.REFINE: StageFacts(True, found)})
    path = tmp_path_factory.mktemp("failed") / "failed.html"
    path.write_text(render_page(build_report(run)), encoding="utf-8")
    opened = Opened(browser, path, DESKTOP)
    yield opened
    opened.page.close()


@pytest.mark.parametrize(
    ("run", "looks"),
    [("desk", (("light", DESKTOP), ("dark", PHONE))), ("failed", (("dark", DESKTOP), ("light", PHONE)))],
)
def test_axe_finds_nothing(
    request: pytest.FixtureRequest, run: str, looks: tuple[tuple[str, dict[str, int]], ...]
) -> None:
    """In both themes, on desktop and phone, axe-core has no objection, and nothing scrolls sideways."""
    from axe_playwright_python.sync_playwright import Axe

    opened = request.getfixturevalue(run)
    opened.page.evaluate(UNFOLD)
    for theme, size in looks:
        opened.page.emulate_media(color_scheme=theme)
        opened.page.set_viewport_size(size)
        result = Axe().run(opened.page)
        assert len(result.response["passes"]) > 30
        assert [(one["id"], one["nodes"][0]["html"]) for one in result.response["violations"]] == []
        assert opened.page.evaluate("() => document.documentElement.scrollWidth") <= size["width"]
    opened.page.emulate_media(color_scheme="light")
    opened.page.set_viewport_size(DESKTOP)
    assert opened.complaints() == []


def test_a_foreign_script_does_not_run(failed: Opened) -> None:
    """The policy of the page holds: a script and a style that are not its own do nothing, and are reported."""
    failed.page.evaluate(FOREIGN)
    assert failed.page.evaluate("() => window.foreign") is None
    assert failed.page.locator("h1").is_visible()
    assert len(failed.complaints()) >= 2


def test_tab_goes_through_the_page_in_order(desk: Opened) -> None:
    """Tab stops follow the order of the page, and each of them shows that it has the focus."""
    desk.page.set_viewport_size(DESKTOP)
    desk.page.evaluate(UNFOLD)
    # After a click, what has the focus shows it only once a key was pressed.
    desk.page.keyboard.press("Tab")
    desk.page.locator(".skip").focus()
    stops = [desk.page.evaluate(FOCUS)]
    while len(stops) < 100:
        desk.page.keyboard.press("Tab")
        stop = desk.page.evaluate(FOCUS)
        if stop[1] <= stops[-1][1]:
            break
        stops.append(stop)
    tags = [tag for tag, *_ in stops]
    assert tags[0] == "A"
    # Play, four views and six turns; time and one of the paths; speed; configuration.
    assert [tags.count(tag) for tag in ("BUTTON", "INPUT", "SELECT", "PRE")] == [11, 2, 1, 1]
    assert tags.count("SUMMARY") == desk.page.locator("summary").count()
    assert tags.count("DIV") == desk.page.locator(".scroll").count()
    assert all(style == "solid" and width >= 2 for _, _, style, width in stops)


def test_the_machine_turns_without_a_mouse(desk: Opened) -> None:
    """Each button of the camera turns the view, and its opposite turns it back."""
    desk.page.locator("#cameras button").first.click()
    before = np.array(desk.page.evaluate(EYE))
    for there, back in (
        ("Turn left", "Turn right"),
        ("Look from higher up", "Look from lower down"),
        ("Closer", "Farther"),
    ):
        desk.page.get_by_role("button", name=there, exact=True).press("Enter")
        assert np.linalg.norm(np.array(desk.page.evaluate(EYE)) - before) > 0.1
        assert desk.page.locator("#cameras button[aria-pressed=true]").count() == 0
        desk.page.get_by_role("button", name=back, exact=True).press("Enter")
        assert np.allclose(desk.page.evaluate(EYE), before, atol=1e-9)


def test_keys_outside_the_motion_keep_their_meaning(desk: Opened) -> None:
    """Letters and arrows are shortcuts only where the motion has the focus (WCAG 2.1.4)."""
    desk.page.evaluate("document.activeElement.blur()")
    for key in ("c", "ArrowRight", "End"):
        desk.page.keyboard.press(key)
    assert desk.page.locator("input[value=refined]").is_checked()
    assert desk.page.locator("#time").input_value() == "0"


def test_the_theme_may_change(desk: Opened) -> None:
    """When the theme changes, page and plots do so at once, and the instant stays."""
    desk.go_to(40)
    for theme, palette in (("dark", DARK), ("light", LIGHT)):
        desk.page.emulate_media(color_scheme=theme)
        desk.settle()
        ground = desk.page.evaluate("() => getComputedStyle(document.body).backgroundColor")
        assert ground == f"rgb({', '.join(str(int(palette.ground[i : i + 2], 16)) for i in (1, 3, 5))})"
        assert set(desk.page.evaluate(ON_PAPER)["text"]) == {palette.text}
        assert desk.page.locator("#time").input_value() == "40"
    desk.go_to(0)


def test_on_paper(desk: Opened) -> None:
    """Before it is printed, the page is light, unfolded, and as wide as paper; afterwards it is as it was."""
    desk.page.emulate_media(color_scheme="dark")
    desk.page.evaluate("() => document.querySelectorAll('details').forEach(one => { one.open = false; })")
    desk.page.wait_for_function(f"() => document.getElementById('timeline').layout.font.color === '{DARK.text}'")
    before = desk.page.evaluate(ON_PAPER)
    desk.page.emulate_media(media="print")
    desk.page.evaluate("dispatchEvent(new Event('beforeprint'))")
    paper = desk.page.evaluate(ON_PAPER)
    assert paper["folded"] == 0
    assert all(300 < width <= 680 for width in (*paper["widths"], paper["still"]))
    assert set(paper["text"]) == {LIGHT.text}
    assert desk.page.evaluate(STILL) > 20, "the machine is not on paper"
    assert not desk.page.locator("#play").is_visible()
    desk.page.emulate_media(media="screen", color_scheme="dark")
    desk.page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert desk.page.evaluate(ON_PAPER) == before
    assert before["still"] == 0
    desk.page.emulate_media(color_scheme="light")
    assert desk.complaints() == []


def test_a_browser_that_cannot_unpack_says_so(browser: Any, file: Path) -> None:
    """Where the plots cannot be drawn, a note says what they need, and the rest of the page is there."""
    opened = Opened(browser, file, DESKTOP, prepare="delete window.DecompressionStream;")
    opened.page.locator("#no-pictures").wait_for(state="visible", timeout=20_000)
    assert "Firefox 113" in opened.page.locator("#no-pictures").inner_text()
    assert opened.page.locator("#certificate table").count() >= 1
    opened.page.close()
