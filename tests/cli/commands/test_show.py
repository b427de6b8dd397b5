"""What `show` refuses before there is a page; the page itself is tested in tests/show."""

import sys
from pathlib import Path

import pytest

from tests.cli.calls import Call
from tests.conftest import CONFIGS


def test_what_is_opened_has_to_be_there(call: Call) -> None:
    """A path that leads nowhere is named, with what is expected."""
    result = call("show", "none.yaml")
    assert result.exit_code == 2
    assert "none.yaml does not exist: give a CONFIG file or the folder of a run" in result.stderr


def test_a_folder_has_to_be_that_of_a_run(call: Call, tmp_path: Path) -> None:
    """Any other folder is refused."""
    result = call("show", tmp_path)
    assert result.exit_code == 2
    assert "is not a run folder" in result.stderr


def test_a_simulated_motion_needs_its_run(call: Call) -> None:
    """Without the run there is no path to compare it with."""
    result = call("show", CONFIGS / "quick.yaml", "--simulated", "twin.csv")
    assert result.exit_code == 2
    assert "--simulated goes with the folder of a RUN" in result.stderr


@pytest.mark.parametrize("source", [(), (CONFIGS / "quick.yaml",)], ids=["reference machine", "own machine"])
def test_without_viser_it_says_what_to_install(
    call: Call, monkeypatch: pytest.MonkeyPatch, source: tuple[Path, ...]
) -> None:
    """The extra is named, with the exit code of a bad usage."""
    monkeypatch.setitem(sys.modules, "viser", None)
    result = call("show", *source, "--no-browser")
    assert result.exit_code == 2
    assert "pip install 'gantry-tau[show]'" in result.stderr
