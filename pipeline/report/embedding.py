"""What a page carries within itself: compressed texts, and a policy that allows its own scripts and styles alone."""

import base64
import gzip
import hashlib
from collections.abc import Iterable
from functools import cache

from plotly.offline import get_plotlyjs

_LEVEL = 4
"""Of compression: the highest one takes twice as long for 4 % less."""
_EMPTY_STYLE = ""
"""The drawing library fills an empty style element through the CSSOM, which the policy leaves to allowed scripts."""


def compressed(text: str) -> str:
    """Compress a text, gzip in base64; the same text gives the same result."""
    return base64.b64encode(gzip.compress(text.encode(), _LEVEL, mtime=0)).decode()


def security_policy(scripts: Iterable[str], styles: Iterable[str]) -> str:
    """Write the Content-Security-Policy of a page that loads nothing: only these texts run as scripts or styles."""
    return "; ".join(
        (
            "default-src 'none'",
            f"script-src {_sources(scripts)}",
            f"style-src {_sources((*styles, _EMPTY_STYLE))}",
            "img-src data: blob:",
            "base-uri 'none'",
            "form-action 'none'",
        )
    )


@cache
def drawing_library() -> tuple[str, str]:
    """Give the drawing library, and the same compressed."""
    library = get_plotlyjs()
    return library, compressed(library)


def _sources(texts: Iterable[str]) -> str:
    return " ".join(f"'{_hash(text)}'" for text in texts)


def _hash(text: str) -> str:
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}"
