"""Whatever a configuration holds: one message with the key or place, exit code 2, no traceback."""

from itertools import chain
from pathlib import Path

import pytest

from tests.cli.bad_inputs.configurations import BadConfig, bad_values, broken_rules, no_configurations
from tests.cli.calls import invoke

CASES = list(chain(bad_values(), broken_rules(), no_configurations()))


@pytest.mark.parametrize("bad", CASES, ids=lambda bad: bad.name)
def test_a_bad_configuration_is_refused(bad: BadConfig) -> None:
    """The message names the file and the key, shows no control characters, and is short."""
    Path("bad.yaml").write_text(bad.text, encoding="utf-8")
    result = invoke("check", "bad.yaml")
    assert result.exit_code == 2
    assert result.stderr.startswith("error: bad.yaml cannot be used:\n")
    for part in bad.expected:
        assert part in result.stderr
    assert all(character.isprintable() or character == "\n" for character in result.stderr)
    assert len(result.stderr) < 20_000
    # What is wrong with the task only does not keep `check` from showing the machine.
    assert result.stdout == "" or "degrees of freedom in this task" in result.stdout
    assert "is valid" not in result.stdout
