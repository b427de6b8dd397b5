"""Lines in words."""

import pytest

from pipeline.measured.reading.account import Skipped, line_ranges


@pytest.mark.parametrize(
    ("lines", "most", "expected"),
    [
        ((4,), None, "4"),
        ((1, 2, 3, 7, 9, 10), None, "1-3, 7, 9-10"),
        ((1, 3, 5, 7), 2, "1, 3 and 2 more places"),
        ((), None, ""),
    ],
)
def test_lines_are_ranges(lines: tuple[int, ...], most: int | None, expected: str) -> None:
    """Consecutive lines are one range; a message has a few ranges."""
    assert line_ranges(lines, most) == expected


def test_one_and_many() -> None:
    """Counts are in plain English."""
    assert str(Skipped("without values", (7,))) == "1 line without values (7)"
    assert str(Skipped("of comment", tuple(range(1, 2001)))) == "2,000 lines of comment (1-2000)"
