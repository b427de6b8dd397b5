"""Arguments that docstrings exclude: public functions refuse them, and say which, what it is and what to give."""

import dataclasses
import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import BSpline, PPoly

import pipeline
from pipeline import (
    MODES,
    Machine,
    Path,
    Reflectors,
    SimulationSetting,
    Trajectory,
    Uncertainty,
    WorkspaceSetting,
)
from pipeline.arguments import (
    require_array,
    require_number,
    require_one_length,
    require_shape,
    require_whole,
    require_whole_numbers,
)
from pipeline.certify import prove_path
from pipeline.config import Config
from pipeline.errors import ArgumentError, UsageError
from pipeline.measured import Measurement
from pipeline.retime import stretched
from tests.certify.paths import ends_of, line_path

NAN, INF = np.nan, np.inf
POSE, Q = np.array([[1.02, 0.3, 0.9, 0.0, -0.7, 0.0]] * 2), np.full((2, 5), 0.5)
H = np.tile(np.eye(6), (2, 1, 1))
WRONG_M = Uncertainty(length_m=1e-5)


@dataclass(frozen=True, eq=False)
class Given:
    """What arguments are made of."""

    config: Config
    machine: Machine
    path: Path
    trajectory: Trajectory


@pytest.fixture(scope="module")
def given_(agder_config: Config, machine: Machine) -> Given:
    """Make a short path, and a motion along it without any planning."""
    path = line_path(machine)
    return Given(agder_config, machine, path, Trajectory(path, PPoly([[-2.0], [3.0], [0.0], [0.0]], [0.0, 1.0])))


def _corner(g: Given, spline: BSpline) -> Path:
    return Path(g.machine, spline, g.path.node_s, g.path.node_pose)


def _spline(g: Given, change: Callable[[Any], Any]) -> Path:
    """Make the path with other coefficients, as a user may: in place, since `BSpline` checks them."""
    spline = BSpline(g.path.spline.t, g.path.spline.c.copy(), g.path.spline.k)
    spline.c[...] = change(spline.c)
    return dataclasses.replace(g.path, spline=spline)


def _measurement() -> Measurement:
    return Measurement(np.array([0.0, 1.0]), None, np.zeros((2, 5)))


CASES: dict[str, tuple[Callable[[Given], object], str]] = {
    # The machine at poses
    "inverse_kinematics: shape": (lambda g: pipeline.inverse_kinematics(g.machine, np.zeros(4), [0]), "controlled: "),
    "inverse_kinematics: mode": (lambda g: pipeline.inverse_kinematics(g.machine, np.zeros(5), [8]), "modes: "),
    "inverse_kinematics: no whole mode": (
        lambda g: pipeline.inverse_kinematics(g.machine, np.zeros(5), [0.5]),
        "whole",
    ),
    "inverse_kinematics: below zero": (lambda g: pipeline.inverse_kinematics(g.machine, np.zeros(5), [-1]), "modes: "),
    "inverse_kinematics: a name": (lambda g: pipeline.inverse_kinematics(g.machine, np.zeros(5), ["LLL"]), "modes: "),
    "inverse_kinematics: rows": (lambda g: pipeline.inverse_kinematics(g.machine, Q, [0]), "controlled 2, modes 1"),
    "inverse_kinematics: gate": (
        lambda g: pipeline.inverse_kinematics(g.machine, Q, [0, 0], np.array([4, 0])),
        "gates",
    ),
    "inverse_kinematics: complex": (lambda g: pipeline.inverse_kinematics(g.machine, Q * 1j, [0, 0]), "real numbers"),
    "forward_kinematics: shape": (lambda g: pipeline.forward_kinematics(g.machine, np.zeros((2, 4)), POSE), "q_m: "),
    "forward_kinematics: guess": (lambda g: pipeline.forward_kinematics(g.machine, Q, POSE[:, :5]), "guess: "),
    "forward_kinematics: guesses": (lambda g: pipeline.forward_kinematics(g.machine, Q, np.zeros((3, 6))), "guess: "),
    "forward_kinematics: tolerance": (lambda g: pipeline.forward_kinematics(g.machine, Q, POSE, 0.0), "tolerance_m: "),
    "statics_matrix: pose": (lambda g: pipeline.statics_matrix(g.machine, POSE[:, :5], Q[:, :3]), "pose: "),
    "statics_matrix: carts": (lambda g: pipeline.statics_matrix(g.machine, POSE, Q), "carts_m: "),
    "condition_number: shape": (lambda g: pipeline.condition_number(H[:, :5]), "H: "),
    "condition_number: NaN": (lambda g: pipeline.condition_number(H * NAN), "H: .*finite"),
    "det_sign: shape": (lambda g: pipeline.det_sign(np.eye(5)), "H: "),
    "link_distances: pose": (lambda g: pipeline.link_distances(g.machine, POSE[0], Q[:, :3]), "pose: "),
    "link_distances: rows": (lambda g: pipeline.link_distances(g.machine, POSE, Q[:1, :3]), "pose 2, carts_m 1"),
    "min_distances: carts": (lambda g: pipeline.min_distances(g.machine, POSE, Q), "carts_m: "),
    # Stages
    "plan_routes: none": (lambda g: pipeline.plan_routes(g.config, g.machine, None, 0), "count: "),
    "plan_routes: half": (lambda g: pipeline.plan_routes(g.config, g.machine, None, 1.5), "count: .*whole"),
    "prove_path: NaN": (lambda g: _prove_changed(g), "coefficients of the path: .*nan"),
    "slowed: faster": (lambda g: pipeline.slowed(g.trajectory, 2.0), "speed: .*at most 1, not 2"),
    "slowed: not at all": (lambda g: pipeline.slowed(g.trajectory, 0.0), "speed: .*more than 0"),
    "slowed: back": (lambda g: pipeline.slowed(g.trajectory, -0.5), "speed: "),
    "slowed: NaN": (lambda g: pipeline.slowed(g.trajectory, NAN), "speed: "),
    "slowed: several": (lambda g: pipeline.slowed(g.trajectory, [0.5, 0.6]), "speed: expected a number"),
    "slowed: truth": (lambda g: pipeline.slowed(g.trajectory, True), "speed: expected real numbers"),
    "slowed: for ever": (lambda g: pipeline.slowed(g.trajectory, 5e-324), "duration_s: .*inf"),
    "stretched: no time": (lambda g: stretched(g.trajectory, 0.0), "duration_s: "),
    "stretched: NaN": (lambda g: stretched(g.trajectory, NAN), "duration_s: "),
    # Paths
    "Path: complex": (lambda g: _corner(g, BSpline(g.path.spline.t, g.path.spline.c + 1e-9j, 5)), "coefficients.*real"),
    "Path: NaN": (lambda g: _spline(g, lambda c: c * NAN), "coefficients of the path: .*nan"),
    "Path: infinite": (lambda g: _spline(g, lambda c: c * INF), "coefficients of the path: .*inf"),
    "Path: four actuators": (lambda g: _corner(g, BSpline(g.path.spline.t, g.path.spline.c[:, :4], 5)), "coefficients"),
    "Path: nodes": (lambda g: dataclasses.replace(g.path, node_pose=g.path.node_pose[:, :5]), "node_pose: "),
    "Path: rows": (lambda g: dataclasses.replace(g.path, node_s=g.path.node_s[:-1]), "node_s 40, node_pose 41"),
    "Path: order": (lambda g: dataclasses.replace(g.path, node_s=g.path.node_s[::-1]), "node_s: .*increase"),
    "Path: NaN node": (lambda g: dataclasses.replace(g.path, node_pose=g.path.node_pose * NAN), "node_pose: .*nan"),
    "Path.q: beyond": (lambda g: g.path.q(1.5), "s: .*at most 1, not 1.5"),
    "Path.q: before": (lambda g: g.path.q([0.5, -0.1]), r"s: .*-0.1 \(at \[1\]\)"),
    "Path.q: NaN": (lambda g: g.path.q(NAN), "s: "),
    "Path.q: derivative": (lambda g: g.path.q(0.5, -1), "derivative: "),
    "Path.pose: beyond": (lambda g: g.path.pose(2.0), "s: "),
    "Path.pose: NaN": (lambda g: g.path.pose([NAN]), "s: "),
    "kappa_along: beyond": (lambda g: pipeline.kappa_along(g.path, [1.1]), "s: "),
    "kappa_along: table": (lambda g: pipeline.kappa_along(g.path, np.zeros((2, 2))), "s: .*shape"),
    "sample_path: one": (lambda g: pipeline.sample_path(g.path, 0.5), "s: .*shape"),
    "sample_path: beyond": (lambda g: pipeline.sample_path(g.path, np.array([-1.0])), "s: "),
    "measure_path: steps": (lambda g: pipeline.measure_path(_samples(g, 3), np.zeros(5)), "steps: "),
    "measure_path: four steps": (lambda g: pipeline.measure_path(_samples(g, 3), np.ones(4)), "steps: "),
    "measure_path: one sample": (lambda g: pipeline.measure_path(_samples(g, 1), np.ones(5)), "samples: "),
    "pose_derivatives: beyond": (lambda g: pipeline.pose_derivatives(g.path, [1.1]), "s: "),
    "pose_spline: tolerance": (lambda g: pipeline.pose_spline(g.path, -1e-9), "tolerance_m: "),
    "pose_spline: NaN": (lambda g: pipeline.pose_spline(g.path, tolerance_rad=NAN), "tolerance_rad: "),
    "blended: smooth": (lambda g: pipeline.blended(g.path), "coarse: .*degree 1"),
    "blended: tolerance": (lambda g: pipeline.blended(g.path, -1.0), "tolerance_m: "),
    # Motions
    "Trajectory: waits": (lambda g: dataclasses.replace(g.trajectory, dwell_s=(-1.0, 0.0)), "dwell_s: "),
    "Trajectory: late": (lambda g: Trajectory(g.path, PPoly([[1.0], [0.0]], [1.0, 2.0])), "time law"),
    "Trajectory: NaN": (lambda g: Trajectory(g.path, PPoly([[NAN], [0.0]], [0.0, 1.0])), "time law: .*nan"),
    "Trajectory.q: NaN": (lambda g: g.trajectory.q(NAN), "t_s: "),
    "Trajectory.q: infinite": (lambda g: g.trajectory.q(INF), "t_s: "),
    "Trajectory.q: derivative": (lambda g: g.trajectory.q(0.0, 4), "derivative: .*0 to 3, not 4"),
    "Trajectory.s: NaN": (lambda g: g.trajectory.s([0.0, NAN]), r"t_s: .*\[1\]"),
    "Trajectory.pose: NaN": (lambda g: g.trajectory.pose(np.array([NAN])), "t_s: "),
    "sample_trajectory: period": (lambda g: pipeline.sample_trajectory(g.trajectory, 0.0), "period_s: "),
    "sample_trajectory: NaN": (lambda g: pipeline.sample_trajectory(g.trajectory, NAN), "period_s: "),
    # Comparisons, workspace, measured motions, pictures
    "compare_runs: one": (lambda g: pipeline.compare_runs([]), "measured: "),
    "WorkspaceSetting: step": (lambda g: WorkspaceSetting(step_m=0.0), "step_m: "),
    "WorkspaceSetting: kappa": (lambda g: WorkspaceSetting(kappa_max=0.5), "kappa_max: "),
    "WorkspaceSetting: tilt": (lambda g: WorkspaceSetting(rx_rad=NAN), "rx_rad: "),
    "Reflectors: NaN": (lambda g: Reflectors(np.array([[NAN, 0.0, 0.0], [0.0, 0.4, 0.0]]), 0.0), "points_m: .*nan"),
    "Reflectors: one": (lambda g: Reflectors(np.zeros((1, 3)), 0.0), "points_m: "),
    "Reflectors: noise": (lambda g: Reflectors(np.zeros((2, 3)), -1.0), "noise_m: "),
    "SimulationSetting: error": (lambda g: SimulationSetting(geometry_std_m=-1.0), "geometry_std_m: "),
    "SimulationSetting: seed": (lambda g: SimulationSetting(seed=-1), "seed: "),
    "simulate_measurement: rows": (
        lambda g: pipeline.simulate_measurement(g.machine, Q, POSE[:1], None, SimulationSetting()),
        "q_m 2, commanded 1",
    ),
    "compare_measurement: rows": (
        lambda g: pipeline.compare_measurement(_measurement(), np.zeros((3, 6)), None),
        "commanded poses: .*2, 6",
    ),
    "Deviations: geometry": (lambda g: pipeline.Deviations(geometry_std_m=NAN), "geometry_std_m: "),
    "Deviations: mass": (lambda g: pipeline.Deviations(mass_error=-1.0), "mass_error: .*more than -1"),
    "Deviations: seed": (lambda g: pipeline.Deviations(seed=-1), "seed: "),
    "plan_motion: period": (lambda g: pipeline.plan_motion(_moving(g), 0.0), "period_s: "),
    "bound_pose_error: precision": (lambda g: pipeline.bound_pose_error(g.path, WRONG_M, 52), "precision_bits: "),
    "sample_pose_error: s": (lambda g: pipeline.sample_pose_error(g.path, WRONG_M, np.array([1.1])), "s: "),
    "sample_pose_error: draws": (
        lambda g: pipeline.sample_pose_error(g.path, WRONG_M, np.array([0.5]), -1),
        "draws: ",
    ),
    "simulate_motion: standing": (lambda g: _simulated(g, standing_s=-1.0), "standing_s: "),
    "tune_drives: damping": (lambda g: pipeline.tune_drives(*_driven(g), None, 1.5), "damping: .*at most 1"),
    "kappa_map: mode": (lambda g: pipeline.kappa_map(g.machine, [0.0], [0.5], (0.0, 0.0), len(MODES)), "mode: "),
    "kappa_map: tilt": (lambda g: pipeline.kappa_map(g.machine, [0.0], [0.5], (0.0, NAN), 0), "tilt_rad: "),
    "kappa_map: grid": (lambda g: pipeline.kappa_map(g.machine, 0.0, [0.5], (0.0, 0.0), 0), "y_m: "),
    "kappa_map_figure: none": (lambda g: pipeline.kappa_map_figure({}), "maps: "),
    "postures_figure: none": (lambda g: pipeline.postures_figure(g.machine, POSE[:0], Q[:0]), "pose: "),
    "postures_figure: rows": (lambda g: pipeline.postures_figure(g.machine, POSE, Q[:1]), "pose 2, q_m 1"),
}


def _samples(g: Given, count: int) -> Any:
    return pipeline.sample_path(g.path, np.linspace(0.0, 1.0, count))


def _moving(g: Given) -> Trajectory:
    """Move the machine of the configuration, which has masses."""
    path = dataclasses.replace(g.path, machine=pipeline.build_machine(g.config.machine))
    return dataclasses.replace(g.trajectory, path=path)


def _driven(g: Given) -> tuple[Machine, Any]:
    machine = pipeline.build_machine(g.config.machine)
    return machine, pipeline.build_drives(g.config.drives, machine)


def _simulated(g: Given, standing_s: float) -> object:
    machine, drives = _driven(g)
    return pipeline.simulate_motion(
        machine, pipeline.build_plant(machine, pipeline.Deviations()), drives, None, standing_s
    )


def _prove_changed(g: Given) -> object:
    """Change the coefficients of a path after it was made."""
    ends = ends_of(g.machine, g.path, (0, 0))
    spline = BSpline(g.path.spline.t, g.path.spline.c.copy(), g.path.spline.k)
    path = dataclasses.replace(g.path, spline=spline)
    spline.c[3, 2] = NAN
    return prove_path(g.config, g.machine, path, ends)


@pytest.mark.parametrize("case", CASES)
def test_what_a_docstring_excludes_is_refused(given_: Given, case: str) -> None:
    """Naming the argument, what it is, and what is expected; it is an error for users, and a ValueError."""
    call, words = CASES[case]
    with pytest.raises(ArgumentError, match=words) as caught:
        call(given_)
    assert isinstance(caught.value, ValueError)
    assert isinstance(caught.value, UsageError)


CHECKED_OTHERWISE = {
    "load_config parse_config dump_config build_machine step_sizes": "configurations are checked when they are read",
    "build_drives build_plant": "configurations, and deviations that are checked when made",
    "build_regions plan_route refine_path certify_path retime_path way_back": "configurations and results of stages",
    "make_atlas": "configurations",
    "run_pipeline open_results load_path save_path read_atlas": "files and folders, with errors of their own",
    "kappa_profile measure_trajectory measure_motion compare_paths": "results, checked when made",
    "usable_workspace measure_space": "settings and results, checked when made",
    "export_files format_samples parse_measurement read_measurement": "tests/export and tests/measured",
    "markdown_table runs_markdown error_rows workspace_rows": "results",
}
"""Public functions that take nothing but results and configurations, or are tested elsewhere."""


def test_every_public_function_is_here_or_takes_only_results() -> None:
    """A new function needs rows of what its docstring excludes, or a reason why there is nothing."""
    functions = {name for name in pipeline.__all__ if inspect.isfunction(getattr(pipeline, name))}
    figures = {name for name in functions if name.endswith("_figure") or name == "all_figures"}
    tested = {case.split(":")[0].split(".")[0] for case in CASES}
    elsewhere = {name for names in CHECKED_OTHERWISE for name in names.split()}
    assert functions - figures - tested - elsewhere == set()
    assert elsewhere <= functions
    assert not tested & elsewhere


def test_times_before_and_after_a_motion_are_at_rest(given_: Given) -> None:
    """That is what the docstring says of them: nothing is extrapolated."""
    waiting = dataclasses.replace(given_.trajectory, dwell_s=(0.5, 0.5))
    ends = given_.path.q(np.array([0.0, 1.0]))
    np.testing.assert_array_equal(waiting.q(np.array([-9.0, 0.2, 1.7, 1e9])), ends[[0, 0, 1, 1]])
    assert not waiting.q(np.array([-9.0, 0.2, 1.7, 1e9]), 1).any()


def test_rounding_may_carry_s_past_an_end(given_: Given) -> None:
    """A last bit beyond one is no mistake of the caller."""
    np.testing.assert_allclose(given_.path.q(1.0 + 1e-12), given_.path.q(1.0), atol=1e-9)


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=1, max_size=5))
def test_what_is_allowed_passes_unchanged(values: list[float]) -> None:
    """Lists and arrays alike."""
    for given_values in (values, tuple(values), np.array(values)):
        np.testing.assert_array_equal(require_array("x", given_values, ("n",)), np.array(values))
    assert require_number("x", values[0], least=values[0], largest=values[0]) == values[0]


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: require_array("x", [[1.0], [1.0, 2.0]], ("n", 2)), "x: its rows are of different lengths"),
        (lambda: require_array("x", ["a"], ("n",)), "x: expected real numbers"),
        (lambda: require_array("x", None, ("n",)), "x: expected real numbers, not None"),
        (lambda: require_array("x", 1.0, ("n",)), r"x: expected an array of shape \(n,\), not of \(\)"),
        (lambda: require_array("x", np.zeros(3), ("...", 6)), r"\(..., 6\), not of \(3,\)"),
        (lambda: require_array("x", np.longdouble(1.0), ()), "x: expected real numbers"),
        (lambda: require_array("x", [0.0, -1.0], ("n",), least=0.0), r"at least 0, not -1 \(at \[1\]\)"),
        (lambda: require_shape("x", [1.0], ("n",)), "x: expected an array of shape"),
        (lambda: require_number("x", INF), "x: expected a finite number, not inf"),
        (lambda: require_number("x", 0.0, above=0.0, largest=1.0), "more than 0 and at most 1, not 0"),
        (lambda: require_whole("x", 2.5, 0, 3), "x: expected a whole number, not 2.5"),
        (lambda: require_whole("x", 7, 0, 3), "at least 0 and at most 3, not 7"),
        (lambda: require_whole_numbers("x", [0.0, 0.5], 0, 3), r"whole numbers, not 0.5 \(at \[1\]\)"),
        (lambda: require_one_length(x=[1], y=[1, 2]), "not x 1, y 2"),
    ],
)
def test_refusals_say_what_was_given_and_expected(call: Callable[[], object], words: str) -> None:
    """In one line."""
    with pytest.raises(ArgumentError, match=words):
        call()
