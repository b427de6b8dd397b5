"""Key paths lead where they say, or the nearest ones are named."""

import pytest

from pipeline.study.keys import UnknownKeyError, flat, nested_paths, parts_of, replaced, scalars, value_at

DATA = {"machine": {"rails": [{"y_m": 1.0}, {"y_m": 2.0}]}, "task": {"tilt_max_deg": 30.0, "locked_axes": []}}


def test_every_path_leads_to_its_value() -> None:
    """What `flat` names, `value_at` finds."""
    assert all(value_at(DATA, path) is value for path, value in flat(DATA))
    assert parts_of("machine.rails[1].y_m") == ("machine", "rails", 1, "y_m")


def test_a_path_that_begins_another_is_found() -> None:
    """And so is the same one written otherwise; a key that only begins with the same letters is another."""
    assert nested_paths(["machine.rails[0].y_m", "task", "machine.rails"]) == ("machine.rails", "machine.rails[0].y_m")
    assert nested_paths(["machine.rails[0]", "machine.rails[00]"]) == ("machine.rails[0]", "machine.rails[00]")
    assert nested_paths(["task.tilt", "task.tilt_max_deg", "machine.rails[0]", "machine.rails[1]"]) is None


@pytest.mark.parametrize(
    ("path", "near"),
    [
        ("task.tilt_max", "task.tilt_max_deg"),
        ("machine.rails[2].y_m", "machine.rails[0].y_m"),
        ("tilt_max_deg", "task"),
        ("task.tilt_max_deg[0]", "task.tilt_max_deg"),
    ],
)
def test_a_path_that_leads_nowhere(path: str, near: str) -> None:
    """Its message names the nearest ones."""
    with pytest.raises(UnknownKeyError, match="near it are") as raised:
        value_at(DATA, path)
    assert near in str(raised.value)


@pytest.mark.parametrize("path", ["", ".", "a..b", "a[", "a[x]", "a b", "a.[0]"])
def test_what_is_not_a_path(path: str) -> None:
    """It is refused as such."""
    with pytest.raises(UnknownKeyError, match="is not a key's path"):
        parts_of(path)


def test_changes_leave_the_original_as_it_is() -> None:
    """Only the copy has the new value."""
    changed = replaced(DATA, {"machine.rails[1].y_m": 9.0, "task.locked_axes": ["rx"]})
    assert value_at(changed, "machine.rails[1].y_m") == 9.0
    assert value_at(DATA, "machine.rails[1].y_m") == 2.0
    assert scalars(changed)["task.locked_axes[0]"] == "rx"
