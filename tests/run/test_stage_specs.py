"""The rows of the stages."""

import inspect
import json
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest
import yaml

from pipeline.config import Config
from pipeline.run.stage_specs import SPECS, Deferred, StageSpec, code_roots, report_of, spec_of
from pipeline.run.up_to_date.source_code import modules_of, shapes_results
from pipeline.stage import STAGES, Stage
from tests.cli.calls import subprocess_env


def test_every_stage_has_a_row_in_order() -> None:
    """Stages run in the order of their rows, after the stages whose results they are given."""
    assert tuple(spec.stage for spec in SPECS) == STAGES
    for spec in SPECS:
        assert set(spec.upstream) <= set(spec.stage.earlier)
        assert all(spec_of(SPECS, stage).load is not None for stage in spec.upstream)


@pytest.mark.parametrize("spec", SPECS, ids=lambda spec: spec.stage)
def test_functions_exist(spec: StageSpec) -> None:
    """A function named in a row exists, and takes what it will be called with."""
    counts = {"make": 2, "load": 1, "words": 1, "in_summary": 1, "explain": 2, "report": 2}
    for field, count in counts.items():
        function = getattr(spec, field)
        if isinstance(function, Deferred):
            assert len(inspect.signature(getattr(import_module(function.module), function.name)).parameters) == count


@pytest.mark.parametrize("spec", SPECS, ids=lambda spec: spec.stage)
def test_files_belong_to_one_stage(spec: StageSpec) -> None:
    """Result file and files shown are among the files of the stage, and no other stage has them."""
    assert not spec.result or spec.result in spec.files
    others = {name for other in SPECS if other is not spec for name in other.patterns}
    assert not others & set(spec.patterns)
    folders = {name.split("/")[0] for name in spec.files}
    assert {name for name, _ in spec.shown} <= set(spec.files) | folders


def test_one_stage_makes_the_report() -> None:
    """The report of an incomplete run is made by the last stage's code."""
    assert [spec.stage for spec in SPECS if spec.report is not None] == [Stage.FIGURES]
    assert report_of(SPECS) is spec_of(SPECS, Stage.FIGURES).report


@pytest.mark.slow
def test_the_code_of_a_stage_is_all_that_it_runs(tmp_path: Path, quick_config: Config) -> None:
    """Every module whose functions a stage really calls is part of its code: no change of it can go unnoticed."""
    data = quick_config.model_dump(mode="json")
    data["task"]["goal"] = data["task"]["start"] | {"y_m": 0.5}
    data["route"]["grid"] |= {"rx_step_deg": 15, "rz_step_deg": 15}
    data["refine"] |= {"nodes": 40, "coefficients": 16, "check_points": 1_000, "max_meshes": 1}
    data["retime"] |= {"jerk_pieces": 40, "grid_points": 200, "bound_points": 100}
    (tmp_path / "small.yaml").write_text(yaml.safe_dump(data))
    for stage in STAGES:
        arguments = ["-m", "tests.run.called_modules", str(tmp_path / "small.yaml"), str(tmp_path / "run"), stage]
        done = subprocess.run(
            [sys.executable, *arguments],
            capture_output=True,
            text=True,
            check=True,
            cwd=Path(__file__).parents[2],
            env=subprocess_env(),
        )
        called = {module for module in json.loads(done.stdout) if shapes_results(module)}
        assert len(called) > 20
        assert called <= modules_of(code_roots(SPECS, stage))
