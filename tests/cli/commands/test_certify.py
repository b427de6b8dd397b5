"""The proof on the command line; the stages are fakes, and so is their certificate."""

import json
from pathlib import Path

import pytest
import yaml

from pipeline.config.file import load_config
from pipeline.errors import NoSolutionError
from tests.cli.calls import Call, edit
from tests.run.fake_stages import FakeStages


class TestCertify:
    """The proof on the command line; the stages are fakes, and so is their certificate."""

    def test_a_refused_path_ends_the_run(
        self, call: Call, config_file: Path, stages: FakeStages, tmp_path: Path
    ) -> None:
        """Exit 1, the path kept, no trajectory, and a verdict that cannot be missed."""
        stages.failures["certify"] = NoSolutionError(
            "certify", "no way at s = 0.3", "widen", {"status": "not certified"}
        )
        result = call("run", config_file, "--out", tmp_path / "out")
        assert result.exit_code == 1
        assert "no way at s = 0.3" in result.stderr
        told = json.loads((tmp_path / "out" / "summary.json").read_text())
        assert told["certificate"]["verdict"] == "not certified"
        assert told["trajectory"] == {"status": "skipped"}
        assert (tmp_path / "out" / "path.npz").exists()
        assert (tmp_path / "out" / "failed" / "certify.json").exists()
        assert not (tmp_path / "out" / "certificate.json").exists()

    def test_tolerances_are_asked_for(self, call: Call, config_file: Path, stages: FakeStages, tmp_path: Path) -> None:
        """They are searched and reported; the configuration does not change."""
        result = call("certify", config_file, "--tolerance", "--out", tmp_path / "out")
        assert result.exit_code == 0
        assert "link lengths may be wrong by 0.10 mm" in result.stdout
        assert stages.proofs == ["tolerances"]
        certificate = json.loads((tmp_path / "out" / "certificate.json").read_text())
        assert certificate["settings"]["what"] == "tolerances"
        assert load_config(tmp_path / "out" / "config.yaml").certify.what == "path"

    def test_tolerances_cost_nothing_else(
        self, call: Call, config_file: Path, stages: FakeStages, tmp_path: Path
    ) -> None:
        """The trajectory stays, to the byte; figures and report, which show the proof, are to be made again."""
        out = tmp_path / "out"
        call("run", config_file, "--out", out)
        before = {file: file.read_bytes() for file in out.rglob("*.*") if file.is_file()}
        stages.taken()
        result = call("certify", config_file, "--tolerance", "--out", out)
        assert f"Out of date, and moved to {out / 'superseded' / '0001'}: report.html, figures" in result.stdout
        assert stages.taken() == ["certify"]
        kept = {file: content for file, content in before.items() if file.exists()}
        changed = {file.name for file, content in kept.items() if file.read_bytes() != content}
        assert changed == {"certificate.json", "summary.json", "state.json"}
        assert {file.suffix for file in before.keys() - kept.keys()} == {".png", ".html"}
        assert not list((out / "superseded").rglob("trajectory.*"))
        assert "Out of date" not in call("run", config_file, "--out", out).stdout
        assert stages.taken() == ["figures"]

    @pytest.mark.parametrize("command", ["run", "retime", "certify"])
    def test_tolerances_once_found_stay(
        self, call: Call, config_file: Path, stages: FakeStages, tmp_path: Path, command: str
    ) -> None:
        """A certificate that proves more than is asked for is up to date."""
        out = tmp_path / "out"
        call("run", config_file, "--out", out)
        call("certify", config_file, "--tolerance", "--out", out)
        certificate = (out / "certificate.json").read_bytes()
        stages.taken()
        assert call(command, config_file, "--out", out).exit_code == 0
        assert stages.calls == (["figures"] if command == "run" else [])
        assert (out / "certificate.json").read_bytes() == certificate
        assert json.loads((out / "summary.json").read_text())["certificate"]["tolerance_m"] == 1e-4
        assert "link lengths may be wrong by 0.10 mm" in call(command, config_file, "--out", out).stdout

    def test_a_weaker_certificate_is_not_enough(
        self, call: Call, config_file: Path, stages: FakeStages, tmp_path: Path
    ) -> None:
        """Tolerances are searched although the path is proven, a second time only where the path is another one."""
        for again in (["certify"], []):
            call("certify", config_file, "--out", tmp_path / "out")
            stages.taken()
            call("certify", config_file, "--tolerance", "--out", tmp_path / "out")
            assert stages.calls == again
        stages.taken()
        call("certify", edit(config_file, route__kappa_max=90.0), "--out", tmp_path / "out")
        assert "certify" in stages.calls
        assert stages.proofs[-1] == "path"

    def test_nothing_is_proven_where_nothing_is_asked(
        self, call: Call, config_file: Path, stages: FakeStages, tmp_path: Path
    ) -> None:
        """The summary says so."""
        config = yaml.safe_load(config_file.read_text())
        config_file.write_text(yaml.safe_dump({**config, "certify": {"what": "nothing"}}))
        assert call("certify", config_file, "--out", tmp_path / "out").exit_code == 0
        told = json.loads((tmp_path / "out" / "summary.json").read_text())
        assert told["certificate"]["verdict"] == "skipped"
        assert "certify" not in stages.calls

    def test_a_certificate_that_does_not_hold(
        self, call: Call, config_file: Path, stages: FakeStages, tmp_path: Path
    ) -> None:
        """A claim that is not verified is reported, with exit code 1."""
        call("certify", config_file, "--out", tmp_path / "out")
        result = call("certify", "--check", tmp_path / "out" / "certificate.json")
        assert result.exit_code == 1
        assert "NO" in result.stdout
        assert "does not hold" in result.stderr

    def test_options_that_exclude_each_other(self, call: Call, config_file: Path, tmp_path: Path) -> None:
        """Verifying searches nothing, and proving needs a configuration."""
        assert call("certify").exit_code == 2
        assert call("certify", config_file, "--check", tmp_path / "certificate.json").exit_code == 2
        assert call("certify", "--check", tmp_path / "certificate.json").exit_code == 2
