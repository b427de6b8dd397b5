"""The commands that run stages."""

from pathlib import Path

import pytest

from pipeline.config.file import load_config
from pipeline.errors import NoSolutionError
from tests.cli.calls import ESCAPE, Call, edit
from tests.run.fake_stages import FakeStages


class TestRun:
    """The commands that run stages."""

    def test_run(self, call: Call, config_file: Path, stages: FakeStages, tmp_path: Path) -> None:
        """A run writes to results/<name>, and reports what it did, where its results are and what to do next."""
        result = call("run", config_file)
        assert result.exit_code == 0
        assert (tmp_path / "results" / "quick" / "trajectory.csv").exists()
        for text in ("regions", "optimal", "converged", "gap 0.00%", "results/quick/trajectory.csv", "Next:"):
            assert text in result.stdout
        assert "regions: started" in result.stderr
        assert "figures: done" in result.stderr
        assert ESCAPE not in result.output

    def test_run_without_a_way_back(
        self, call: Call, config_file: Path, stages: FakeStages, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
    ) -> None:
        """What there is is shown, and the run ends with 1, why, and what to change."""
        stages.no_way_back = NoSolutionError("retime", "on the way back, c2 is too weak", "a stronger one")
        result = call("run", config_file)
        assert result.exit_code == 1
        assert "done in part" in " ".join(result.stdout.split())
        assert "results/quick/trajectory.csv" in result.stdout
        assert "trajectory_back.csv" not in result.stdout
        assert "Next:" not in result.stdout
        assert "on the way back, c2 is too weak" in result.stderr
        assert "What to change: a stronger one" in result.stderr
        assert (tmp_path / "results" / "quick" / "trajectory.csv").exists()

    def test_second_run(self, call: Call, config_file: Path, stages: FakeStages) -> None:
        """What is up to date is said to be unchanged."""
        call("run", config_file)
        stages.taken()
        result = call("run", config_file)
        assert stages.calls == []
        assert "optimal, unchanged" in result.stdout
        assert "route: unchanged" in result.stderr

    def test_pdf(self, call: Call, config_file: Path, stages: FakeStages, tmp_path: Path) -> None:
        """Figures are PDFs only on request, which costs nothing but the figures; all else stays to the byte."""
        out = tmp_path / "out"
        call("run", config_file, "--out", out)
        assert not list(out.glob("figures/*.pdf"))
        trajectory = (out / "trajectory.json").read_bytes()
        stages.taken()
        assert call("run", config_file, "--pdf", "--out", out).exit_code == 0
        assert stages.taken() == ["figures"]
        assert [file.stem for file in out.glob("figures/*.pdf")] == [file.stem for file in out.glob("figures/*.png")]
        assert (out / "trajectory.json").read_bytes() == trajectory
        assert load_config(out / "config.yaml").figures.pdf

    @pytest.mark.parametrize(
        ("command", "expected"),
        [
            ("route", ["regions", "route"]),
            ("refine", ["regions", "route", "refine"]),
            ("certify", ["regions", "route", "refine", "certify"]),
            ("retime", ["regions", "route", "refine", "certify", "retime"]),
        ],
    )
    def test_stage_commands(
        self, call: Call, config_file: Path, stages: FakeStages, command: str, expected: list[str]
    ) -> None:
        """The commands named after stages run up to that stage, and again only when forced."""
        result = call(command, config_file, "--out", "here")
        assert result.exit_code == 0
        assert stages.taken() == expected
        assert "Next: gantry-tau" in result.stdout
        assert "--out here" in result.stdout
        call(command, config_file, "--out", "here")
        assert stages.taken() == []
        call(command, config_file, "--out", "here", "--force")
        assert stages.calls == expected

    def test_range_options(self, call: Call, config_file: Path, stages: FakeStages) -> None:
        """--from and --to choose the stages."""
        assert call("run", config_file, "--to", "refine").exit_code == 0
        assert stages.taken() == ["regions", "route", "refine"]
        assert call("run", config_file, "--from", "refine", "--to", "retime").exit_code == 0
        assert stages.calls == ["refine", "certify", "retime"]

    def test_verbose(self, call: Call, config_file: Path, stages: FakeStages) -> None:
        """-v lets the solvers talk."""
        call("refine", config_file, "-v")
        call("refine", config_file, "--force", "--verbose")
        call("run", config_file, "--force")
        assert stages.verbose == [True] * 4 + [False] * 2

    def test_no_solution(self, call: Call, config_file: Path, stages: FakeStages) -> None:
        """No solution is exit code 1 with reason, advice, and where the diagnosis is; earlier stages are kept."""
        stages.failures["route"] = NoSolutionError("route", "no route exists [proven]", "allow more tilt")
        result = call("run", config_file)
        assert result.exit_code == 1
        assert "error: route: no route exists [proven]\n  What to change: allow more tilt\n" in result.stderr
        assert "results/quick/failed/route.json" in result.stderr
        assert "Traceback" not in result.output
        assert result.stdout == ""
        assert Path("results/quick/regions.npz").exists()

    def test_interrupt(self, call: Call, config_file: Path, stages: FakeStages) -> None:
        """Ctrl-C in a stage ends with 130 and one line; what was finished is kept."""
        stages.failures["refine"] = KeyboardInterrupt()
        result = call("run", config_file)
        assert result.exit_code == 130
        assert result.stderr.splitlines()[-1] == "interrupted: nothing is lost, finished stages are kept"
        assert Path("results/quick/route.csv").exists()
        assert not Path("results/quick/path.npz").exists()

    def test_unusable_folder(self, call: Call, config_file: Path, stages: FakeStages, tmp_path: Path) -> None:
        """A folder that cannot be written to is named, with exit code 2."""
        (tmp_path / "file").touch()
        for out in ("file", "file/deeper", "/proc/none"):
            result = call("run", config_file, "--out", out)
            assert result.exit_code == 2
            assert out in result.stderr
            assert "Traceback" not in result.output

    def test_foreign_folder(self, call: Call, config_file: Path, stages: FakeStages, tmp_path: Path) -> None:
        """Someone's own config.yaml is not overwritten by the resolved one."""
        mine = config_file.rename(tmp_path / "config.yaml")
        before = mine.read_bytes()
        result = call("run", mine, "--out", ".")
        assert result.exit_code == 2
        assert "is not a run folder" in result.stderr
        assert mine.read_bytes() == before

    def test_rerun_from_the_results(self, call: Call, config_file: Path, stages: FakeStages) -> None:
        """The resolved configuration in a run folder is one like any other, and gives the same results."""
        call("run", config_file)
        stages.taken()
        result = call("run", "results/quick/config.yaml")
        assert result.exit_code == 0
        assert stages.calls == []

    @pytest.mark.parametrize("name", [".", ".."])
    def test_name_that_is_no_folder(self, call: Call, config_file: Path, stages: FakeStages, name: str) -> None:
        """A name that would write beside the results is refused."""
        result = call("run", edit(config_file, name=name))
        assert result.exit_code == 2
        assert stages.calls == []
