"""A stage's part of `summary.json`: what all of them have in common."""

from collections.abc import Mapping
from typing import Any

SKIPPED = "skipped"
QUALITY = "quality"
"""The key of the motion's quality, which refining and timing know in part each."""
DRIVES = "drives"
"""The key of what the drives feel, which timing finds and which is a part of its own."""
WORKSPACE = "workspace"
"""The key of the workspace against the installation space, found with the regions, which is a part of its own."""

Section = dict[str, Any]


def failure_section(reason: str, advice: str, status: str = "failed") -> Section:
    """Describe a stage without a result: the reason, and what to change."""
    return {"status": status, "reason": reason, "advice": advice}


def without_part(name: str, failure: Section) -> Section:
    """Describe a stage whose result is there but for a part, which failed."""
    return {"status": "done in part", name: failure}


def failed_part(section: Mapping[str, Any]) -> Section | None:
    """Give the part that failed (the way back) of a stage that has a result; None if none failed."""
    back = section.get("back")
    return back if isinstance(back, dict) and back.get("status") == "failed" else None


def own_or_skipped(section: Section | None) -> Section:
    """Put a section into the summary as it is; None, for a stage without one, becomes "skipped"."""
    return {"status": SKIPPED} if section is None else section
