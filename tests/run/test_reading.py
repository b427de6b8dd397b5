"""Results of a run that is over."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from pipeline.config import Config
from pipeline.errors import (
    ConfigError,
    NoSolutionError,
    UsageError,
)
from pipeline.run import RunOptions, Stage, open_results, run_pipeline
from pipeline.run.reading import open_tubes, with_retime
from tests.run.fake_stages import FakeStages, proven
from tests.run.folders import ALL

Change = Callable[..., Config]


class TestReading:
    """Results of a run that is over."""

    def test_missing_stage(self, tmp_path: Path, fast_config: Config, stages: FakeStages) -> None:
        """A missing result is reported."""
        stages.run(fast_config, tmp_path, last=Stage.ROUTE)
        with pytest.raises(UsageError, match="no result of refine yet"):
            open_results(tmp_path, Stage.REFINE)
        assert len(open_results(str(tmp_path), Stage.ROUTE).route) == 4

    def test_failed_stage(self, tmp_path: Path, fast_config: Config, stages: FakeStages) -> None:
        """A failed stage has no result, and its reason is reported."""
        stages.failures["refine"] = NoSolutionError("refine", "too narrow", "widen")
        with pytest.raises(NoSolutionError):
            stages.run(fast_config, tmp_path)
        with pytest.raises(UsageError, match="failed: too narrow"):
            open_results(tmp_path, Stage.REFINE)

    def test_damaged_stage(self, tmp_path: Path, fast_config: Config, stages: FakeStages) -> None:
        """A result that was edited by hand is not taken for the run's."""
        stages.run(fast_config, tmp_path)
        (tmp_path / "path.npz").write_bytes(b"mine")
        with pytest.raises(UsageError, match=r"removed or changed after the run: path\.npz"):
            open_results(tmp_path, Stage.REFINE)

    def test_tube(self, tmp_path: Path, fast_config: Config, stages: FakeStages) -> None:
        """It is that of the certificate; there is none without a chain of all actuators, or without a certificate."""
        stages.run(fast_config, tmp_path, last=Stage.REFINE)
        assert open_tubes(tmp_path) == ()
        stages.run(fast_config, tmp_path)
        assert open_tubes(tmp_path) == ()
        run_pipeline(fast_config, tmp_path, RunOptions(force=True), None, proven(stages, 1e-3))
        (tube,) = open_tubes(tmp_path)
        assert tube.errors_m.tolist() == [1e-3] * 5
        (tmp_path / "certificate.json").write_bytes(b"{}")
        with pytest.raises(UsageError, match=r"certificate\.json"):
            open_tubes(tmp_path)

    def test_results_of_another_version(self, tmp_path: Path, fast_config: Config, stages: FakeStages) -> None:
        """Results made by other code can still be read, and are made again when stages run."""
        stages.run(fast_config, tmp_path)
        state = json.loads((tmp_path / "state.json").read_text())
        for record in state["stages"].values():
            record["fingerprint"] = "0" * 64
        del state["seal"]
        (tmp_path / "state.json").write_text(json.dumps(state))
        stages.taken()
        results = open_results(tmp_path, *list(Stage)[:-1])
        assert results.trajectory.duration_s == 2.0
        assert len(results.certificate.chains) == 3
        stages.run(fast_config, tmp_path)
        assert stages.taken() == ALL

    def test_other_period(self, fast_config: Config) -> None:
        """Another period is held against what configurations allow."""
        assert with_retime(fast_config) is fast_config
        assert with_retime(fast_config, period_s=0.004).retime.period_s == 0.004
        with pytest.raises(ConfigError, match=r"a period of 5 s cannot be used:\n.*retime\.period_s"):
            with_retime(fast_config, period_s=5.0)
