"""Tables in every dialect come back to the last bit, and of damaged ones every line is accounted for."""

import itertools
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.arrays import FloatArray
from pipeline.errors import UsageError
from pipeline.measured.reading import Account, Table, read_table
from tests.fuzzing import fuzz
from tests.measured.reading.dialects import BOMS, CHOICES, NAMES, POSE_NAMES, Dialect, moving, write_table

PREAMBLE = ("Tracker AT960; serial 4711", 'Größe: 3,5 "m"', "", "#\tnote")
HEADER = ",".join(NAMES)
GAPS = ["", "---", "-", "\u2014", "NaN", "nan", "-nan(ind)", "#N/A", "#NV", "n/a", "NULL", "1.#QNAN", "  "]


def read(data: bytes | str) -> Table:
    """Read a table named seen.csv."""
    return read_table(data.encode() if isinstance(data, str) else data, "seen.csv", CHOICES)


def accounted(account: Account) -> list[int]:
    """List the lines an account knows of, each as often as it does."""
    return sorted([account.header_line, *account.row_lines, *(line for one in account.skipped for line in one.lines)])


def require_same(data: bytes, values: FloatArray, lines: list[int], names: tuple[str, ...] = NAMES) -> Table:
    """Require that a file has exactly these values at these lines, and that every line is accounted for once."""
    table = read(data)
    assert tuple(table.columns) == names
    assert np.column_stack(list(table.columns.values())).tobytes() == np.ascontiguousarray(values).tobytes()
    assert table.account.row_lines.tolist() == lines
    assert accounted(table.account) == list(range(1, table.account.line_count + 1))
    return table


def test_every_combination_of_dialects() -> None:
    """Whatever the separator, mark, encoding, line ends, quotes, gaps, order and lines in between: the same bits."""
    values = moving()
    keep = [index for index in range(len(values)) if index not in (1, 4)]
    count = 0
    for separator, mark, encoding, line_end, *flags in itertools.product(
        ",;\t", ".,", BOMS, ("\n", "\r\n", "\r"), *[(False, True)] * 5
    ):
        quoted, blank, preamble, gaps, order = flags
        dialect = Dialect(
            separator,
            mark,
            encoding,
            line_end,
            quoted,
            blank_lines=blank,
            preamble=PREAMBLE if preamble else (),
            gap="---" if gaps else None,
            gap_rows=frozenset({1, 4}),
            order=(3, 6, 0, 1, 5, 4, 2) if order else None,
        )
        data, lines = write_table(values, dialect)
        require_same(data, values[keep] if gaps else values, lines)
        count += 1
    assert count == 3 * 2 * len(BOMS) * 3 * 2**5


finite = st.floats(allow_nan=False, allow_infinity=False)
rows = st.lists(st.tuples(*[finite] * len(NAMES)), min_size=1, max_size=4)
dialects = st.builds(
    Dialect,
    separator=st.sampled_from(",;\t"),
    mark=st.sampled_from(".,"),
    encoding=st.sampled_from(["utf-8", "utf-8-sig", "utf-16-le", "utf-16-be"]),
    line_end=st.sampled_from(["\n", "\r\n", "\r"]),
    quoted=st.booleans(),
    padding=st.sampled_from(["", " ", "  "]),
    preamble=st.sampled_from([(), PREAMBLE, ("sep=;",), ("", "")]),
    units=st.sampled_from([None, "{}", "[{}]", "({})"]),
    blank_lines=st.booleans(),
    comments=st.booleans(),
    last_line_end=st.booleans(),
    trailing_separator=st.booleans(),
    upper_case=st.booleans(),
    order=st.permutations(range(len(NAMES))).map(tuple),
    extra=st.sampled_from([None, "ok", "#1", "5' long", "größer, länger", 'a "b" c', "1;2\t3"]),
    gap=st.sampled_from([None, *GAPS]),
    gap_rows=st.frozensets(st.integers(0, 3)),
    minus=st.sampled_from("-\u2212"),
)


@fuzz(150)
@given(values=rows, dialect=dialects)
def test_any_number_in_any_dialect(values: list[tuple[float, ...]], dialect: Dialect) -> None:
    """Any finite number, written shortest, comes back to the last bit from any dialect, or the file is ambiguous."""
    if dialect.extra is not None and any(char in dialect.extra for char in ',;\t"'):
        dialect = replace(dialect, quoted=True)
    table = np.array([(0.0, *[0.5] * 6), *values])
    gap_rows = frozenset() if dialect.gap is None else dialect.gap_rows - {0}
    keep = [index for index in range(len(table)) if index not in gap_rows]
    data, lines = write_table(table, replace(dialect, gap_rows=gap_rows))
    require_same(data, table[keep], lines)


@fuzz(250)
@given(
    index=st.integers(0, 10**6),
    text=st.text(st.sampled_from('",;\t\n\r 0.-eNa#\ufeff\u00e9\0m'), max_size=3),
    cut=st.integers(0, 5),
)
def test_damaged_tables(index: int, text: str, cut: int) -> None:
    """Wherever something is put in or cut out, a file is refused, or all lines are accounted for and unhurt rows right.

    A cut in the middle of a number leaves a number, and nobody can tell; lines that are as they were have their values.
    """
    values = moving(8)
    dialect = Dialect(
        quoted=index % 2 == 0, extra='see "A", B' if index % 2 == 0 else "ok", comments=True, units="[{}]"
    )
    whole = write_table(values, dialect)[0].decode()
    at = index % (len(whole) + 1)
    damaged = whole[:at] + text + whole[at + cut :]
    known = dict(zip(_lines(whole, write_table(values, dialect)[1]), values, strict=True))
    try:
        table = read(damaged)
    except UsageError as error:
        assert str(error).startswith("seen.csv")
        assert "What to change" in str(error) or "skipped" in str(error)
        return
    account = table.account
    assert accounted(account) == list(range(1, account.line_count + 1))
    got = np.column_stack([table.columns[name] for name in NAMES])
    for line, row in zip(_lines(damaged, account.row_lines.tolist()), got, strict=True):
        if line in known:
            assert np.array_equal(row, known[line])


def _lines(text: str, numbers: list[int]) -> list[str]:
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    return [lines[number - 1] for number in numbers]


@fuzz(100)
@given(data=st.binary(max_size=300))
def test_any_bytes(data: bytes) -> None:
    """Random bytes, alone and behind a header, are refused with a message, or accounted for."""
    for content in (data, HEADER.encode() + b"\n" + data, b"\xff\xfe" + data):
        try:
            account = read(content).account
        except UsageError as error:
            assert str(error).startswith("seen.csv")
        else:
            assert accounted(account) == list(range(1, account.line_count + 1))


@fuzz(100)
@given(
    lines=st.lists(
        st.lists(
            st.sampled_from(["0.5", "1,5", "7", "", "---", '"a"', '"', 'b"c', "x1_m", "1e999", "inf", "#", "1.234,5"]),
            min_size=1,
            max_size=9,
        ).map(",".join),
        max_size=5,
    )
)
def test_any_cells(lines: list[str]) -> None:
    """Rows of any values, right or wrong, are read, skipped or refused with line and what to do."""
    try:
        account = read("\n".join([HEADER, "0.0,1,2,3,4,5,6", *lines, ""])).account
    except UsageError as error:
        assert str(error).startswith("seen.csv, line ")
        assert "What to change" in str(error)
    else:
        assert accounted(account) == list(range(1, account.line_count + 1))


@pytest.mark.parametrize("extra", ["none", "of them"])
def test_a_stray_quote_never_swallows_rows(extra: str) -> None:
    """One quote too many, or two in different lines, in a text column of 762 rows: refused with the first line."""
    lines = ["note," + HEADER, *(f"ok,{k},1,2,3,4,5,6.5" for k in range(762))]
    lines[3] = lines[3].replace("ok", '"ok')
    if extra == "of them":
        lines[761] = lines[761].replace("ok", '"ok')
    with pytest.raises(UsageError, match=r"seen.csv, line 4: a quote is opened and not closed"):
        read("\n".join(lines))


def test_a_quote_that_joins_two_values_is_refused() -> None:
    """Quotes that make one value of two are found by the number of values, even where a separator ends each line."""
    rows = [f"ok,{k},1,2,3,4,5,6.5,7," for k in range(5)]
    rows[2] = '"ok,2",1,2,3,4,5,6.5,7,'
    with pytest.raises(UsageError, match=r"line 4: 9 values, where others have 10, and quotes"):
        read("\n".join([f"note,{HEADER},more", *rows]))


def test_missing_and_additional_empty_values() -> None:
    """Values of ignored columns at the end may be missing, as Excel leaves them out, or be followed by separators."""
    table = read(f"{HEADER},note,more\n0,1,2,3,4,5,6.5\n1,1,2,3,4,5,6.5,a\n2,1,2,3,4,5,6.5,a,b,,,\n")
    assert table.columns["t_s"].tolist() == [0.0, 1.0, 2.0]


def test_a_pose_is_taken_where_reflectors_are_incomplete() -> None:
    """The choice whose names are all there is read, and the account says which."""
    values = moving(4, len(POSE_NAMES))
    data, lines = write_table(values, Dialect(extra="1"), POSE_NAMES)
    account = require_same(data.replace(b"note", b"x1_m"), values, lines, POSE_NAMES).account
    assert "4 rows of t_s, x_m, y_m, z_m, rx_rad, rz_rad" in account.message()


def test_the_account_in_words_and_as_json() -> None:
    """Every reason has its lines in the message and in JSON, the latter with all ranges."""
    dialect = Dialect(
        ";", ",", "utf-16-le", preamble=("Tracker", ""), units="[{}]", gap="---", gap_rows=frozenset({1, 2})
    )
    account = read(write_table(moving(), dialect)[0]).account
    assert account.message().splitlines() == [
        "seen.csv: 3 rows of t_s, x1_m, y1_m, z1_m, x2_m, y2_m, z2_m (UTF-16, semicolons, decimal commas)",
        "  skipped: 2 lines above the header (1-2)",
        "  skipped: 1 line of units (4)",
        "  skipped: 1 line with a gap in x1_m (6)",
        "  skipped: 1 line with a gap in y1_m (7)",
    ]
    assert account.as_json()["rows"] == 3
    assert account.as_json()["skipped"][0] == {"reason": "above the header", "count": 2, "lines": "1-2"}
    assert account.gap_count == 2


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            "0,0,1,0,2,0,3,0,4,0,5,0,6,0",
            r"line 2: 14 values, separated by commas, for 7 columns.\n.*points for decimals",
        ),
        ("0,1,2,3", r"line 2: 4 values, separated by commas, for 7"),
        ("0;1;2;3;4;5;6", r"line 2: 1 value, separated by commas, for 7"),
        ("0,1,2,3,4,5,far", r"line 2, column z2_m: 'far' is not a number"),
        ("0,1,2,3,4,5,6 mm", r"column z2_m: '6 mm' is a number with something behind it"),
        ("0,1,2,3,4,5,inf", r"line 2, column z2_m: 'inf' is not finite"),
        ("0,1,2,3,4,5,-1e999", r"line 2, column z2_m: '-1e999' is too large"),
        ("0,1,2,3,4,5,1_000", r"'1_000' is not a number"),
        ("0,1,2,3,4,5,\u0661", r"is not a number"),
        ("0,1,2,3,4,5,0x1p3", r"'0x1p3' is"),
        ("0,1,2,3,4,5,#DIV/0!", r"'#DIV/0!' is an error of a spreadsheet"),
        ("00:00:01.5,1,2,3,4,5,6", r"column t_s: '00:00:01.5' is a time of day"),
        ('0,1,2,3,4,5,"1.234,5"', r"'1.234,5' has separators of thousands"),
        ("0,1,2,3,4,5,1 234.5", r"'1 234.5' has separators of thousands"),
        ('0,1,2,3,4,5,"1,234"', r"'1,234' may mean 1.234 or 1234"),
        ('0,1,2,3,4,5.5,"6,5"', r"column z2_m: '6,5' has a comma, but '5.5' in line 2, column y2_m, has a point"),
        ('0,1,2,3,4,5,"6"7', r"line 2: a quote is closed in the middle of a value"),
        (f"0,1,2,3,4,5,6\n{HEADER}\n0,1,2,3,4,5,6", r"line 3: the header again"),
        ("s,mm,mm,mm,mm,mm,mm\n0,1,2,3,4,5,6", r"line 2, column x1_m: the unit is mm, but the name .* says m"),
        ("0,1,2,3,4,5,6\nEnd of data", r"line 3: 1 value.*\n.*put # before it"),
        ("0,1,2,3,4,5,a\n1,1,2,3,4,5,b\n2,1,2,3,4,5,c", r"2 more lines cannot be read either"),
        ("0,1,2\n" * 5000, r"line 2: 3 values.*\n.*\n  At least 1,000 more lines cannot be read either"),
        ("---,1,2,3,4,5,6", r"no rows\n  skipped: 1 line with a gap in t_s \(2\)"),
        ("", r"the measurement has no rows"),
    ],
)
def test_refusals(text: str, expected: str) -> None:
    """What is wrong or may mean two things is refused with line, column and what to do."""
    with pytest.raises(UsageError, match=expected):
        read(f"{HEADER}\n{text}")


def test_rows_above_the_header_are_refused() -> None:
    """A header in the middle of a file would hide the rows above it."""
    with pytest.raises(UsageError, match="line 1: a row above the header"):
        read(f"0,1,2,3,4,5,6\n{HEADER}\n1,1,2,3,4,5,6\n")
    with pytest.raises(UsageError, match="line 2, column x1_m: the unit is mm"):
        read(f"Tracker\ns,mm,mm,mm,mm,mm,mm\n\n{HEADER}\n1,1,2,3,4,5,6\n")


def test_the_locale_does_not_matter(tmp_path: Path) -> None:
    """With an ASCII locale the same bytes give the same table."""
    file = tmp_path / "seen.csv"
    file.write_bytes(f"gr\u00f6\u00dfe\n{HEADER}\n0,1,2,3,4,5,\u22126.5\n".encode())
    script = (
        "import sys; from pipeline.measured import read_measurement; read = read_measurement(sys.argv[1], 1.0); "
        "print(read.reflectors_m[0, 1, 2], read.account.encoding)"
    )
    environment = {**os.environ, "LC_ALL": "C", "LANG": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    command = [sys.executable, "-c", script, str(file)]
    result = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    assert result.stdout.split() == ["-6.5", "UTF-8"]


@pytest.mark.parametrize("gap", GAPS)
def test_columns_that_may_have_gaps_hold_nan_there(gap: str):
    """A gap is a NaN in a column that may have one, and skips the row in any other; the decimal mark is not its."""
    lines = ["q;x1_m;x2_m", f"1,5;{gap};3,5", f"{gap};5,25;6,5", "7,5;8,5;9,5"]
    table = read_table("\n".join(lines).encode(), "seen.csv", [("q", "x1_m", "x2_m")], ("x1_m", "x2_m"))
    np.testing.assert_array_equal(np.column_stack(list(table.columns.values())), [[1.5, np.nan, 3.5], [7.5, 8.5, 9.5]])
    assert accounted(table.account) == [1, 2, 3, 4]
    assert table.account.gap_count == 1
