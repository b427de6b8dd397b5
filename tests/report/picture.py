"""A picture of the report for the README: `python -m tests.report.picture REPORT PICTURE`; none without a browser."""

import sys
from io import BytesIO
from pathlib import Path

from PIL import Image

from tests.report.browser import browsing, why_none

_WINDOW = {"width": 1240, "height": 860}
_PART = 0.55
"""Of the motion, at which the picture is taken: between singular loops."""
_SCRUB = """
part => {
  document.getElementById('motion').scrollIntoView();
  const slider = document.getElementById('time');
  slider.value = Math.round(part * slider.max);
  slider.dispatchEvent(new Event('input'));
}
"""


def take(report: Path, picture: Path) -> None:
    """Open the report, go to an instant, and keep what is seen, in 256 colours."""
    with browsing() as browser:
        page = browser.new_page(viewport=_WINDOW)
        page.goto(report.resolve().as_uri())
        page.wait_for_selector("body[data-ready]", timeout=60_000)
        page.evaluate(_SCRUB, _PART)
        page.wait_for_timeout(2_000)
        seen = page.screenshot()
    Image.open(BytesIO(seen)).convert("RGB").quantize(256).save(picture, optimize=True)


if __name__ == "__main__":
    if why_none():
        sys.stderr.write(f"{sys.argv[2]} is left as it is: {why_none()}\n")
    else:
        take(Path(sys.argv[1]), Path(sys.argv[2]))
