"""The header is found by name, and where it is not, the message says what differs."""

import pytest

from pipeline.errors import UsageError
from pipeline.measured.reading.header import find_header, match_columns
from tests.measured.reading.dialects import CHOICES, NAMES

HEADER = ",".join(NAMES)


@pytest.mark.parametrize(
    "line",
    [
        HEADER,
        HEADER.upper(),
        "\ufeff" + HEADER,
        HEADER.replace(",", " , "),
        HEADER.replace(",", ",\u00a0"),
        HEADER.replace("x1", "x\u200b1"),
        '"' + HEADER.replace(",", '","') + '"',
        HEADER.replace(",", ";"),
        HEADER.replace(",", "\t") + "\t",
        "# " + HEADER,
        "%" + HEADER + ",note",
        "no," + HEADER,
    ],
)
def test_names_are_what_matters(line: str) -> None:
    """Case, blanks, invisible characters, quotes, separators, comment marks and other columns do not."""
    header = find_header(["Tracker", line], CHOICES, "seen.csv")
    assert header.line_index == 1
    assert tuple(header.columns) == NAMES


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        (HEADER.replace("x1_m", "\u04451_m"), r"missing: x1_m.*\n.*'\u04451_m' is not x1_m: it has U\+0445 CYRILLIC"),
        (HEADER.replace("x1_m", "x1\u00a0_m"), r"'x1\\xa0_m' is not x1_m: it has U\+00A0 NO-BREAK SPACE"),
        (HEADER.replace("x1_m", "x1\x1b_m"), r"'x1\\x1b_m' is not x1_m: it has U\+001B control character"),
        (HEADER.replace("x1_m", "x1_mm"), r"'x1_mm' is not x1_m: give values in m, and name the column x1_m"),
        (HEADER.replace("t_s", "t_ms"), r"'t_ms' is not t_s: give values in s, and name the column t_s"),
        (HEADER.replace("y2_m", "Y2 [mm]"), r"'Y2 \[mm\]' is not y2_m: give values in m"),
        (HEADER.replace("y2_m", "y2"), r"'y2' is not y2_m: give values in m"),
        (HEADER.replace("y2_m,", ""), r"missing: y2_m; there: 't_s', 'x1_m', 'y1_m', 'z1_m', 'x2_m', 'z2_m'"),
        ("t_s,x_m,y_m,z_m,rx_deg,rz_rad", r"'rx_deg' is not rx_rad: give values in rad"),
        (HEADER + ",x1_m", r"x1_m is named 2 times, as columns 2 and 8"),
        (HEADER.replace(",", " "), r"separated by blanks"),
        (HEADER.replace(",", " | "), r"separated by bars"),
        ("0,1,2,3,4,5,6", r"no line names the columns of a measurement; line 1 already is a row of numbers"),
        ("Tracker 4711", r"no line names the columns of a measurement; line 1 is 'Tracker 4711'"),
        ('"' + HEADER, r"no line names the columns"),
    ],
)
def test_what_differs_is_said(line: str, expected: str) -> None:
    """Names that are nearly right are shown beside those asked for, invisible characters with their names."""
    with pytest.raises(UsageError, match=expected) as caught:
        find_header([line], CHOICES, "seen.csv")
    assert str(caught.value).startswith("seen.csv")
    assert "What to change" in str(caught.value)


def test_lines_of_another_length_are_said_with_missing_columns() -> None:
    """What is wrong with the lines below is said at once."""
    with pytest.raises(UsageError, match=r"line 1: .*\n  missing: y_m.*\n  line 3 has 1 value, not 2"):
        find_header(["t_s,x_m", "1,2", "1"], CHOICES, "seen.csv")


def test_columns_are_matched_by_the_same_rules() -> None:
    """Columns of a program are found as those of a file, and given by the names they have."""
    assert match_columns(["Z_M", "\ufeffT_s", " x_m", "y_m", "rx_rad", "rz_rad", "no"], CHOICES)["t_s"] == "\ufeffT_s"
    with pytest.raises(ValueError, match=r"missing: z_m; there: .*\n  'z' is not z_m"):
        match_columns(["t_s", "x_m", "y_m", "z", "rx_rad", "rz_rad"], CHOICES)
