"""The public interface: its names, that they are documented and typed, and that importing it costs nothing."""

import dataclasses
import fnmatch
import inspect
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import pipeline

PROJECT = Path(__file__).parents[1]

NAMES = """
ArgumentError Certificate ComparisonRow Config ConfigError CsvOptions Deviations Drives ErrorRow ExportOptions
ExportRequest Format ForwardKinematicsError InfeasibleError InverseSolution KappaMap KappaProfile MODES Machine
MeasuredPath Measurement MeasurementComparison Motion MotionFigures NoSolutionError Path PathFigures PathSamples
PipelineError Plant Refinement Reflectors RegionTable Results Route RunData RunOptions RunReport RunsRow Simulation
SimulationSetting Stage Trajectory TrajectoryFigures TrajectorySamples Tuning UsageError Workspace WorkspaceRow
WorkspaceSetting all_figures blended bodies_figure build_drives build_machine build_plant build_regions certify_path
clearance_figure compare_measurement compare_paths compare_runs condition_number det_sign drives_figure dump_config
error_rows export_files format_samples forward_kinematics inverse_kinematics kappa_along kappa_figure kappa_map
kappa_map_figure kappa_profile link_distances load_config load_path loads_figure machine_figure markdown_table
measure_motion measure_path measure_trajectory measured_figure min_distances open_results parse_config
parse_measurement phase_figure plan_motion plan_route plan_routes pose_derivatives pose_figure pose_spline
postures_figure proof_figure read_measurement refine_path regions_figure retime_path route_figure run_pipeline
runs_markdown sample_path sample_trajectory save_path simulate_measurement simulate_motion slowed statics_matrix
step_sizes trajectory_figure tune_drives usable_workspace usage_figure way_back workspace_figure workspace_rows
workspace_volume_figure
AtlasOptions AtlasRecord MotionRecord PairRecord StationRecord make_atlas read_atlas Installation SpaceUse measure_space
PoseError SampledError Uncertainty bound_pose_error pose_error_figure sample_pose_error
"""
PUBLIC = NAMES.split()
MADE_STEP_BY_STEP = {"Results"}


def test_the_names_are_these() -> None:
    """A new or removed name changes everybody's notebooks: it is also changed here."""
    assert sorted(pipeline.__all__) == sorted(PUBLIC)
    assert sorted(dir(pipeline)) == sorted(PUBLIC)


@pytest.mark.parametrize("name", [name for name in PUBLIC if name != "MODES"])
def test_it_is_documented_and_typed(name: str) -> None:
    """Everything has a docstring of its own, and functions have a type for every parameter and their result."""
    thing = getattr(pipeline, name)
    assert thing.__doc__
    assert not thing.__doc__.startswith(f"{name}("), "a dataclass writes such a docstring by itself"
    if inspect.isfunction(thing):
        signature = inspect.signature(thing)
        assert signature.return_annotation is not inspect.Signature.empty
        assert all(one.annotation is not one.empty for one in signature.parameters.values())


def test_results_cannot_be_changed() -> None:
    """What functions return is frozen, but for the results of a run, which are loaded when first asked for."""
    classes = [getattr(pipeline, name) for name in PUBLIC if dataclasses.is_dataclass(getattr(pipeline, name))]
    assert {one.__name__ for one in classes if not one.__dataclass_params__.frozen} == MADE_STEP_BY_STEP


def test_unknown_names_are_attribute_errors() -> None:
    """A missing name is an ordinary AttributeError."""
    with pytest.raises(AttributeError, match="no_such_name"):
        _ = pipeline.no_such_name
    with pytest.raises(ImportError):
        exec("from pipeline import no_such_name")


def test_importing_loads_no_libraries() -> None:
    """`import pipeline` loads neither NumPy nor anything heavier, and a configuration no solver and no plotting."""
    script = """
import sys
import pipeline
assert not {"numpy", "pydantic"} & set(sys.modules)
from pipeline import load_config
assert not {"scipy", "casadi", "highspy", "matplotlib", "flint"} & set(sys.modules)
"""
    subprocess.run([sys.executable, "-c", script], check=True)


def test_types_ship_with_the_package() -> None:
    """The marker by which type checkers know that there are types, and the stub, are files of the package."""
    settings = tomllib.loads((PROJECT / "pyproject.toml").read_text())
    shipped = settings["tool"]["setuptools"]["package-data"]["pipeline"]
    folder = Path(pipeline.__file__).parent
    for name in ("py.typed", "__init__.pyi"):
        assert (folder / name).is_file()
        assert any(fnmatch.fnmatch(name, pattern) for pattern in shipped)
