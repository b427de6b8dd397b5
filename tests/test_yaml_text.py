"""YAML within bounds."""

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from pipeline.yaml_text import MOST_LEVELS, MOST_VALUES, YamlError, parse_yaml
from tests.fuzzing import fuzz

_PLAIN = st.one_of(st.integers(), st.booleans(), st.none(), st.floats(allow_nan=False), st.text(max_size=5))
_DATA = st.recursive(
    _PLAIN,
    lambda part: st.one_of(st.lists(part, max_size=4), st.dictionaries(st.text(max_size=5), part, max_size=4)),
    max_leaves=10,
)
_TOKENS = [
    "a",
    ": ",
    "- ",
    "[",
    "]",
    "{",
    "}",
    ", ",
    "&a ",
    "*a",
    "<<: ",
    "!!int ",
    "!!map ",
    "? ",
    "\n",
    "\n  ",
    "'",
    '"',
]


@given(data=_DATA)
def test_what_is_within_bounds_is_read_as_pyyaml_reads_it(data: object) -> None:
    """The bounds change nothing else."""
    assert parse_yaml(yaml.safe_dump(data)) == data


@fuzz(100)
@given(text=st.lists(st.sampled_from(_TOKENS), max_size=20).map("".join))
def test_whatever_looks_like_yaml_is_read_or_refused(text: str) -> None:
    """No other error comes out, whatever tags, aliases and brackets are put together."""
    try:
        parse_yaml(text)
    except YamlError as error:
        assert error.place.startswith(("line ", "(file)"))


def test_aliases_count_wherever_they_are_used() -> None:
    """Exactly as many as allowed are read; one more is refused, though the file has few."""
    list_of_ten = "a: &a [1, 2, 3, 4, 5, 6, 7, 8, 9]\n"
    # The section, its keys, the list's ten values; then a list of aliases.
    uses = (MOST_VALUES - 1 - 2 - 10 - 1) // 10
    text = f"{list_of_ten}b: [{', '.join(['*a'] * uses)}]"
    data = parse_yaml(text)
    assert isinstance(data, dict)
    assert len(data["b"]) == uses
    with pytest.raises(YamlError, match="50,000 keys and values"):
        parse_yaml(f"{list_of_ten}b: [{', '.join(['*a'] * (uses + 1))}]")


@pytest.mark.parametrize(("opening", "closing"), [("[", "]"), ("{a: ", "}"), ("- ", "")])
def test_nesting_ends_at_a_depth(opening: str, closing: str) -> None:
    """As deep as allowed is read, one more is not."""
    inside = MOST_LEVELS - 1
    assert parse_yaml(opening * inside + "1" + closing * inside) is not None
    with pytest.raises(YamlError, match="nested more than 32 deep"):
        parse_yaml(opening * (inside + 1) + "1" + closing * (inside + 1))


def test_what_is_too_much_ends_before_its_end() -> None:
    """The values are counted while they are read."""
    with pytest.raises(YamlError, match=r"line 25000, column 9: .* more than 50,000"):
        parse_yaml("".join(f"k{k:05}: 1\n" for k in range(40_000)))
