"""Whatever values a configuration holds, allowed or not: it is valid, or refused with the reason."""

import copy
from pathlib import Path
from typing import Any

import yaml
from hypothesis import given
from hypothesis import strategies as st

from pipeline.cli.console import printable
from tests.cli.bad_inputs.configurations import complete, leaves
from tests.cli.calls import invoke
from tests.fuzzing import fuzz

COMPLETE = complete()
LEAVES = list(leaves(COMPLETE))
_NUMBERS = st.one_of(
    st.floats(),
    st.floats(0.0, 10.0),
    st.integers(-3, 300),
    st.sampled_from([0, -0.0, 5e-324, 1e-300, 1e-9, 1.0, 100.0, 1e6, 1e300, 10**30]),
)
_VALUES = st.one_of(
    _NUMBERS,
    st.lists(_NUMBERS, max_size=4),
    st.text(max_size=5),
    st.sampled_from(
        [None, True, False, [], {}, "LLL", "RRR", "sum", "time", "paper", ["rx"], [[1, 2]], {"x_m": [0, 1]}]
    ),
)


@fuzz(8)
@given(changes=st.dictionaries(st.sampled_from(LEAVES), _VALUES, min_size=1, max_size=4))
def test_any_values_are_valid_or_refused(changes: dict[tuple[str | int, ...], Any]) -> None:
    """`check` ends with 0 or, naming a key or what is missing, with 1 or 2; nothing is a traceback."""
    data = copy.deepcopy(COMPLETE)
    for path, value in changes.items():
        part = data
        for key in path[:-1]:
            part = part[key]
        part[path[-1]] = value
    Path("any.yaml").write_text(yaml.safe_dump(data, allow_unicode=True), encoding="utf-8")
    result = invoke("check", "any.yaml")
    assert result.exit_code in (0, 1, 2)
    if result.exit_code:
        assert result.stdout == "" or "in this task" in result.stdout
        assert "is valid" not in result.stdout
        assert result.stderr.startswith("error: ")
        assert len(result.stderr) < 20_000
        assert printable(result.stderr) == result.stderr
