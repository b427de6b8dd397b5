"""A picture of the page for the documentation: `python -m tests.show.page.picture PICTURE`; none without a browser."""

import sys
import tempfile
from io import BytesIO
from pathlib import Path

from PIL import Image

from tests.report.browser import browsing, why_none
from tests.show.page.browsing import PROJECT, Command, Page

_WINDOW = {"width": 1240, "height": 640}
_COLOURS = 256
_TILT_FIELD, _TILT_DEG = 3, "-14"
_SETTLE_MS = 3_000


def take(picture: Path) -> None:
    """Open the reference machine, tilt it until singularities are in the map, and keep what is seen."""
    with tempfile.TemporaryDirectory() as folder, browsing() as browser:
        command = Command(PROJECT / "configs" / "agder.yaml", folder=Path(folder))
        try:
            page = Page(browser, command.address, _WINDOW)
            # A browser without a graphics card is told of: nothing of the page.
            page.page.add_style_tag(content=".mantine-Notifications-root { display: none; }")
            page.fill(_TILT_FIELD, _TILT_DEG)
            page.wait_for(f"rx {float(_TILT_DEG):.2f}")
            page.page.wait_for_timeout(_SETTLE_MS)
            seen = page.page.screenshot()
        finally:
            command.end()
    Image.open(BytesIO(seen)).convert("RGB").quantize(_COLOURS).save(picture, optimize=True)


if __name__ == "__main__":
    if why_none():
        sys.stderr.write(f"{sys.argv[1]} is left as it is: {why_none()}\n")
    else:
        take(Path(sys.argv[1]))
