"""Values put into a YAML text, all else left as it is."""

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.calibrate.yaml_edit import with_values

TEXT = """\
# A machine.
machine:            # with comments
  rails:
    - {y_m: 0.0, z_m: 1.50}   # first
    - y_m: 1e-1
      z_m: 2                  # second
  links: {l1: {length_m: 1.090, point: [0.10, 0, -0.07]}}
  # what follows
  'limits':
    force: 3

task: 5
"""


def test_only_what_changes_changes():
    """Comments, order, blank lines and the spelling of other numbers stay; new keys come last in their section."""
    changes = {
        "machine": {
            "rails": {0: {"z_m": 1.6}, 1: {"y_m": 0.2, "new": True}},
            "links": {"l1": {"point": [1.0, 2.0, 3.0], "extra": 0.5}, "l2": {"length_m": 2.0}},
            "actuators": {"c1": {"zero_m": 0.001}},
        },
        "last": None,
    }
    expected = """\
# A machine.
machine:            # with comments
  rails:
    - {y_m: 0.0, z_m: 1.6}   # first
    - y_m: 0.2
      z_m: 2                  # second
      new: true
  links: {l1: {length_m: 1.090, point: [1.0, 2.0, 3.0], extra: 0.5}, l2: {length_m: 2.0}}
  # what follows
  'limits':
    force: 3
  actuators: {c1: {zero_m: 0.001}}

task: 5
last: null
"""
    assert with_values(TEXT, changes) == expected
    assert with_values(TEXT, {}) == TEXT


@pytest.mark.parametrize(
    "text", ["{}", "{a: {b: 1,}}", "a: {b: 1, }", "a: {}", "a:\n  b: 1", "a:\n  b: [1,\n    2]\n\n"]
)
def test_sections_of_every_spelling_can_be_extended(text: str):
    """Empty sections, trailing commas, values over several lines, and files without a last line end."""
    values = yaml.safe_load(with_values(text, {"a": {"c": 2}, "d": "x: y"}))
    before = (yaml.safe_load(text) or {}).get("a") or {}
    assert values == {"a": {**before, "c": 2}, "d": "x: y"}


_values = st.recursive(
    st.floats(-1e3, 1e3) | st.text("ab:#{} ", max_size=4),
    lambda inner: st.dictionaries(st.text("abc", min_size=1, max_size=2), inner, max_size=3),
    max_leaves=8,
)
_sections = st.dictionaries(st.text("abc", min_size=1, max_size=2), _values, max_size=4)


def _merged(data: object, changes: object) -> object:
    if not isinstance(changes, dict):
        return changes
    kept = data if isinstance(data, dict) else {}
    return {**kept, **{key: _merged(kept.get(key), value) for key, value in changes.items()}}


@settings(max_examples=30)
@given(data=_sections, changes=_sections, flow=st.sampled_from([True, False, None]))
def test_it_reads_as_the_merged_sections(data: dict, changes: dict, flow: bool | None):
    """Whatever is in the file and changed, in block or flow style: the result reads as both merged."""
    text = yaml.safe_dump(data, default_flow_style=flow, sort_keys=False)
    try:
        new = with_values(text, changes)
    except ValueError as error:
        assert str(error).startswith("expected a ")  # a value that would have to become a section, or the reverse
        return
    assert yaml.safe_load(new) == _merged(data, changes)


@pytest.mark.parametrize(
    "text", ["a:\n- 1\n- 0.10 # ten\n- 3", "a: [1,\n  0.10, # ten\n 3]", "a:\n    - 1\n    - 0.10 # ten\n    - 3\nb: 1"]
)
def test_numbers_of_a_list_change_one_by_one(text: str):
    """In any spelling of a list, those that stay are left as they are written."""
    assert with_values(text, {"a": [1.0, 0.1, 4.5]}) == text.replace("3", "4.5")


def test_an_empty_value_is_filled():
    """A key without a value gets one behind its colon."""
    assert with_values("a:\nb: {c: }", {"a": 1.5, "b": {"c": 2.5}}) == "a: 1.5\nb: {c: 2.5 }"


def test_what_is_used_twice_is_refused():
    """A value that has to become two is refused; one that has to become one is not."""
    text = "a: &x [1, 2]\nb: *x"
    assert yaml.safe_load(with_values(text, {"a": [3, 2], "b": [3, 2]})) == {"a": [3, 2], "b": [3, 2]}
    with pytest.raises(ValueError, match="used in several places"):
        with_values(text, {"a": [3, 2], "b": [4, 2]})


def test_what_is_no_section_is_refused():
    """A value cannot get keys."""
    with pytest.raises(ValueError, match="expected a section"):
        with_values("a: 5", {"a": {"b": 1}})
