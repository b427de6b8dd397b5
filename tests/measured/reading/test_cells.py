"""Values are numbers, gaps or neither."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.measured.reading.cells import NUMBER, ROW, DecimalMark, clean_number, is_gap


@given(
    value=st.floats(allow_nan=False, allow_infinity=False), text=st.sampled_from(["{!r}", "{:.12f}", "{:+.3e}", "{:G}"])
)
def test_every_written_number_is_one(value: float, text: str) -> None:
    """Whatever Python writes of a finite number is a number with either mark, and not a gap."""
    written = text.format(value)
    assert NUMBER.fullmatch(written)
    assert NUMBER.fullmatch(written.replace(".", ","))
    assert not is_gap(written)


@given(cells=st.lists(st.text(st.sampled_from("01.,-+eE \t_x\u0661\u00a0"), max_size=5), min_size=1, max_size=4))
def test_the_quick_test_agrees_with_the_slow_one(cells: list[str]) -> None:
    """A row that is told at once to be numbers is one value by value, and `float` reads the same."""
    if ROW.fullmatch("\0".join(cells)):
        for cell in cells:
            text = clean_number(cell)
            assert NUMBER.fullmatch(text)
            assert float(cell) == float(text)


@pytest.mark.parametrize(
    "cell", ["1e", "e5", ".", ",", "1.2.3", "1,2.3", "0x1", "1_0", "\u0661", "1 2", "--1", "", "1d5"]
)
def test_what_is_not_a_number(cell: str) -> None:
    """`float` would read some of them."""
    assert not NUMBER.fullmatch(cell)


def test_the_mark_is_told_by_one_certain_comma() -> None:
    """Commas before three decimals are ambiguous until one number cannot have thousands; whole numbers say nothing."""
    for certain in ("0,5", "0,123", "1,2345", ",5", "1,234e2"):
        mark = DecimalMark()
        mark.see(2, "x_m", "7")
        assert (mark.mark, mark.trouble()) == (".", None)
        mark.see(2, "x_m", "1,234")
        assert mark.trouble() is not None
        mark.see(3, "x_m", certain)
        assert (mark.mark, mark.trouble()) == (",", None)
        mark.see(4, "x_m", "1.5")
        assert mark.trouble() is not None
