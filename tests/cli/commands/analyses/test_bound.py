"""Tests of the command that bounds kappa on every path."""

import json
from pathlib import Path

import pytest

from pipeline.bound.bound import Attempt, Bound
from pipeline.bound.flood import Verdict
from pipeline.bound.theorem import Theorem
from pipeline.cli.commands.analyses.bound import what_next
from pipeline.config.file import dump_config, load_config
from tests.cli.calls import edit, invoke
from tests.conftest import CONFIGS


@pytest.fixture
def stiff(tmp_path: Path) -> Path:
    """Write the reference task without tilt."""
    path = tmp_path / "stiff.yaml"
    path.write_text(dump_config(load_config(CONFIGS / "quick.yaml")))
    return edit(path, task__locked_axes=["rx", "rz"])


def test_the_theorem_is_said_in_words(stiff: Path):
    """Without tilt no path exists, and no boxes are needed; the same as JSON."""
    result = invoke("bound", stiff)
    assert result.exit_code == 0
    assert "no path exists: F is 0.91509 at the start and -0.91032 at the goal" in result.output
    data = json.loads(invoke("bound", stiff, "--json").stdout)
    assert data["no_path"] is True
    assert data["attempts"] == []


def test_a_proof_is_written_and_verified(stiff: Path, tmp_path: Path):
    """What --output writes --check verifies, for the same machine and task only; a changed K does not hold."""
    proof = tmp_path / "bound.npz"
    assert invoke("bound", stiff, "--kappa", 23.5, "--output", proof).exit_code == 0
    checked = invoke("bound", stiff, "--check", proof)
    assert checked.exit_code == 0
    assert "verified. Every path within the limits has kappa > 23.5" in checked.output
    other = edit(stiff, task__tilt_max_deg=20.0)
    refused = invoke("bound", other, "--check", proof)
    assert refused.exit_code == 2
    assert "another machine or task" in refused.output


def test_what_is_not_proven_is_no_path(tmp_path: Path):
    """Too few boxes end with exit code 1, and the message does not claim a path."""
    result = invoke("bound", CONFIGS / "quick.yaml", "--kappa", 30, "--boxes", 2000)
    assert result.exit_code == 1
    assert "does not show a path" in result.output
    assert "raise --boxes, or try --kappa between 23.14 and 30" in " ".join(result.output.split())
    climbed = invoke("bound", CONFIGS / "quick.yaml", "--boxes", 2000)
    assert climbed.exit_code == 0
    assert "For more: raise --boxes" in climbed.output


@pytest.mark.parametrize(
    ("verdicts", "expected"),
    [
        (
            (Verdict.NONE, Verdict.LATE),
            "give K by --kappa: all 1,000 boxes are then for it, of which smaller K took 400",
        ),
        ((Verdict.LATE,), "raise --boxes, or try --kappa between 23 and 24"),
        ((Verdict.NONE, Verdict.OPEN), "try --kappa between 24 and 25; at 25 small boxes join start and goal"),
        ((Verdict.NONE,), ""),
        ((), ""),
    ],
)
def test_advice_fits_how_the_last_flood_ended(verdicts: tuple[Verdict, ...], expected: str):
    """More boxes are advised only where they may help, and K by --kappa where smaller ones took boxes."""
    attempts = tuple(Attempt(24.0 + k, verdict, 400, 5) for k, verdict in enumerate(verdicts))
    proven = [one.kappa for one in attempts if one.verdict == Verdict.NONE]
    found = Bound(Theorem(("the machine may tilt",)), 23.0, max(proven, default=None), attempts, None)
    advice = what_next(found, 1000)
    assert advice.startswith(expected)
    assert bool(advice) == bool(expected)


def test_damaged_proofs_are_refused(stiff: Path, tmp_path: Path):
    """A file of another kind is named, with exit code 2."""
    proof = tmp_path / "bound.npz"
    proof.write_bytes(b"nothing")
    result = invoke("bound", stiff, "--check", proof)
    assert result.exit_code == 2
    assert "cannot be read" in result.output


def test_a_run_is_needed_for_the_gap(stiff: Path, tmp_path: Path):
    """A folder that no run has written is refused before anything is proven."""
    result = invoke("bound", stiff, "--run", tmp_path)
    assert result.exit_code == 2
    assert str(tmp_path) in result.output.replace("\n", "")
