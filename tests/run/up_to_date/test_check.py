"""What runs again, and when."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from pipeline.config import Config
from pipeline.run import Stage, run_pipeline
from pipeline.run.stage_specs import Deferred
from tests.run.fake_stages import FakeStages
from tests.run.folders import ALL, RESULT_FILES, content, files, summary

Change = Callable[..., Config]


class TestCaching:
    """A stage whose inputs have not changed is not run again."""

    def test_nothing_changed(self, tmp_path: Path, fast_config: Config, stages: FakeStages) -> None:
        """A second run does nothing, and leaves the results byte for byte."""
        stages.run(fast_config, tmp_path)
        before = content(tmp_path)
        stages.taken()
        report = stages.run(fast_config, tmp_path)
        assert stages.calls == []
        assert content(tmp_path) == before
        assert [outcome.outcome for outcome in report.outcomes] == ["unchanged"] * 6

    @pytest.mark.parametrize(
        ("key", "value", "again"),
        [
            ("name", "other", ["retime", "figures"]),
            ("machine__links__l1__length_m", 1.1, ["regions", "route", "refine", "certify"]),
            ("machine__clearance__link_link_m", 0.02, ["regions", "route", "refine", "certify"]),
            ("machine__limits__carts__velocity_mps", 0.4, ["refine", "certify"]),
            ("machine__limits__carts__acceleration_mps2", 1.9, []),
            ("task__goal__z_m", 0.91, ["regions", "route", "refine", "certify"]),
            ("task__tilt_max_deg", 25.0, ["regions", "route", "refine", "certify"]),
            ("task__locked_axes", ["rz"], ["regions", "route", "refine", "certify"]),
            ("task__budget__travel_m", 9.0, ["route", "refine", "certify"]),
            ("route__grid__y_m__step", 0.2, ["regions", "route", "refine", "certify"]),
            ("route__kappa_max", 90.0, ["regions", "route", "refine", "certify"]),
            ("route__x_step_m", 0.2, ["route", "refine", "certify"]),
            ("route__step_budget", 24, ["route", "refine", "certify"]),
            ("route__follow__max_samples", 32, ["route", "refine", "certify"]),
            ("refine__nodes", 90, ["refine", "certify"]),
            ("refine__check_points", 1_001, ["refine", "certify"]),
            ("certify__kappa_excess", 0.1, ["certify"]),
            ("certify__what", "tolerances", ["certify"]),
            ("certify__monte_carlo_samples", 9, []),
            ("certify__tolerance_resolution", 0.5, []),
            ("retime__period_s", 0.02, []),
            ("retime__jerk", False, []),
            ("machine__dynamics__load_kg", 1.0, ["regions", "route", "refine", "certify"]),
            ("machine__dynamics__platform__inertia_kgm2", [0.2, 0.2, 0.2], []),
            ("machine__limits__tcp__speed_mps", 0.3, []),
        ],
    )
    def test_what_runs_again(
        self,
        tmp_path: Path,
        fast_config: Config,
        stages: FakeStages,
        change: Change,
        key: str,
        value: Any,
        again: list[str],
    ) -> None:
        """Each key runs exactly the stages again that read it, and those whose files quote the configuration."""
        stages.run(fast_config, tmp_path)
        stages.taken()
        stages.run(change(fast_config, **{key: value}), tmp_path)
        assert stages.calls == [*again, *(stage for stage in ("retime", "figures") if stage not in again)]

    def test_files_quote_the_current_configuration(
        self, tmp_path: Path, fast_config: Config, stages: FakeStages, change: Change
    ) -> None:
        """After any change the hash in the trajectory's sidecar is that of the summary."""
        stages.run(fast_config, tmp_path)
        stages.run(change(fast_config, route__step_budget=24), tmp_path)
        sidecar = json.loads((tmp_path / "trajectory.json").read_text())
        assert sidecar["config_sha256"] == summary(tmp_path)["config_sha256"]

    def test_other_result_runs_later_stages(self, tmp_path: Path, fast_config: Config, stages: FakeStages) -> None:
        """When a stage comes out differently, everything that builds on it runs again."""
        stages.run(fast_config, tmp_path)
        stages.taken()
        stages.objective = 101.0
        stages.run(fast_config, tmp_path, first=Stage.ROUTE, last=Stage.ROUTE)
        assert stages.taken() == ["route"]
        assert files(tmp_path) & RESULT_FILES == {"regions.npz", "route.npz", "route.csv"}
        stages.run(fast_config, tmp_path)
        assert stages.calls == ["refine", "certify", "retime", "figures"]

    def test_same_result_stops_the_chain(self, tmp_path: Path, fast_config: Config, stages: FakeStages) -> None:
        """When a stage run again comes out the same, what builds on it stays good."""
        stages.run(fast_config, tmp_path)
        before = content(tmp_path)
        stages.taken()
        stages.run(fast_config, tmp_path, first=Stage.ROUTE, last=Stage.ROUTE)
        assert stages.taken() == ["route"]
        stages.run(fast_config, tmp_path)
        assert stages.calls == []
        assert {name: content(tmp_path)[name] for name in RESULT_FILES} == {name: before[name] for name in RESULT_FILES}
        assert not (tmp_path / "superseded").exists()

    def test_another_version(
        self, tmp_path: Path, fast_config: Config, stages: FakeStages, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """Another version of the package makes all results outdated."""
        stages.run(fast_config, tmp_path)
        stages.taken()
        monkeypatch.setattr("pipeline.run.up_to_date.fingerprint.package_version", lambda: "99.0")
        stages.run(fast_config, tmp_path)
        assert stages.taken() == ALL

    @pytest.mark.parametrize(("stage", "again"), [(Stage.RETIME, ["retime", "figures"]), (Stage.FIGURES, ["figures"])])
    def test_other_code(
        self, tmp_path: Path, fast_config: Config, stages: FakeStages, stage: Stage, again: list[str]
    ) -> None:
        """Other words of a stage make its result outdated, and the figures, whose report quotes them."""
        stages.run(fast_config, tmp_path)
        stages.taken()
        other = stages.with_row(stage, words=Deferred("pipeline.summary.versions", "versions"))
        run_pipeline(fast_config, tmp_path, specs=other)
        assert stages.taken() == again

    @pytest.mark.parametrize(
        ("name", "again"),
        [
            ("regions.npz", ["regions"]),
            ("route.csv", ["route"]),
            ("route.npz", ["route"]),
            ("path.csv", ["refine"]),
            ("trajectory.json", ["retime"]),
            ("figures/kappa.png", ["figures"]),
        ],
    )
    @pytest.mark.parametrize("damage", ["edited", "removed"])
    def test_damaged_files_are_made_anew(
        self, tmp_path: Path, fast_config: Config, stages: FakeStages, name: str, again: list[str], damage: str
    ) -> None:
        """A file that was edited or removed makes its stage run again; the edited one is kept aside."""
        stages.run(fast_config, tmp_path)
        good = (tmp_path / name).read_bytes()
        stages.taken()
        if damage == "edited":
            (tmp_path / name).write_bytes(b"mine")
        else:
            (tmp_path / name).unlink()
        stages.run(fast_config, tmp_path)
        assert stages.calls == again
        assert (tmp_path / name).read_bytes() == good
        if damage == "edited":
            assert (tmp_path / "superseded" / "0001" / name).read_bytes() == b"mine"

    @pytest.mark.parametrize("state", [b"", b"nonsense", b"{}"])
    def test_damaged_state_runs_everything(
        self, tmp_path: Path, fast_config: Config, stages: FakeStages, state: bytes
    ) -> None:
        """Without a readable state nothing counts as done, and old files move aside when they are replaced."""
        stages.run(fast_config, tmp_path)
        (tmp_path / "state.json").write_bytes(state)
        stages.taken()
        stages.objective = 101.0
        stages.run(fast_config, tmp_path, last=Stage.ROUTE)
        assert stages.calls == ["regions", "route"]
        assert files(tmp_path) & RESULT_FILES == {"regions.npz", "route.npz", "route.csv"}
        assert "superseded/0001/trajectory.csv" in files(tmp_path)

    def test_force(self, tmp_path: Path, fast_config: Config, stages: FakeStages) -> None:
        """Forced, everything in range runs again."""
        stages.run(fast_config, tmp_path)
        stages.taken()
        stages.run(fast_config, tmp_path, force=True)
        assert stages.taken() == ALL
        stages.run(fast_config, tmp_path, force=True, last=Stage.ROUTE)
        assert stages.taken() == ["regions", "route"]
        stages.run(fast_config, tmp_path, force=True, first=Stage.RETIME)
        assert stages.taken() == ["retime", "figures"]
