"""A Gaussian filter finds nothing to gain in a refined path: it is as smooth as is worth its integral of kappa."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.interpolate import BSpline
from scipy.ndimage import gaussian_filter1d

from pipeline.config import Config
from pipeline.errors import ForwardKinematicsError
from pipeline.machine import Machine
from pipeline.refine import Path, refine_path
from pipeline.refine.measure import measure_path, sample_path
from pipeline.refine.splines import DEGREE, fit
from pipeline.retime import retime_path
from pipeline.route import build_regions, plan_route
from pipeline.route.metric import step_sizes

Vary = Callable[[Config, dict[str, object]], Config]
S = np.linspace(0.0, 1.0, 2_001)
WIDTHS = (0.04, 0.02, 0.01, 0.005, 0.0025)
"""Standard deviations of the filter, in s."""
EQUAL = 1.001
"""Ratio of integrals up to which they count as equal."""
TASKS: dict[str, dict[str, object]] = {
    "modes change": {},
    "modes change, reversed and diagonal": {
        "task.start": {"x_m": 1.02, "y_m": 0.2, "z_m": 1.0, "mode": "RRR"},
        "task.goal": {"x_m": 1.02, "y_m": 0.5, "z_m": 0.8, "mode": "LLL"},
    },
    "along X": {"task.start.x_m": 1.0, "task.goal.x_m": 2.2, "task.goal.mode": "LLL"},
    "across, tilting": {
        "task.start.rx_deg": 10.0,
        "task.goal": {"x_m": 1.2, "y_m": 0.1, "z_m": 0.8, "rx_deg": -10.0, "mode": "LLL"},
    },
    "across in RRR": {
        "task.start.mode": "RRR",
        "task.goal": {"x_m": 0.8, "y_m": 0.6, "z_m": 0.7, "mode": "RRR"},
    },
}


@pytest.mark.slow
@pytest.mark.parametrize("task", TASKS)
def test_a_filtered_path_of_equal_integral_is_no_faster(
    quick_config: Config, machine: Machine, vary: Vary, task: str
) -> None:
    """By more than one per cent: filtered as widely as leaves the integral as it is."""
    config = vary(quick_config, TASKS[task])
    path = refine_path(config, machine, plan_route(config, machine, build_regions(config, machine))).path
    integral = _integral(config, path)
    equal = (filtered for width in WIDTHS if _integral(config, filtered := _filtered(path, width)) < EQUAL * integral)
    filtered = next(equal)
    coarse_law = vary(config, {"retime.jerk_pieces": 100})
    before, after = (retime_path(coarse_law, each).timing.motion_s for each in (path, filtered))
    assert after > 0.99 * before


def _integral(config: Config, path: Path) -> float:
    try:
        return measure_path(sample_path(path, S), step_sizes(config.route)).kappa_integral
    except ForwardKinematicsError:
        return np.inf


def _filtered(path: Path, width: float) -> Path:
    """Filter what a path has beyond the straight line between its ends, which stay where they are."""
    q = path.q(S)
    line = q[0] + S[:, None] * (q[-1] - q[0])
    beyond = q - line
    # Odd about both ends: the filter leaves them at zero.
    whole = np.concatenate([-beyond[:0:-1], beyond, -beyond[-2::-1]])
    smooth = gaussian_filter1d(whole, width * (len(S) - 1), axis=0)[len(S) - 1 : 2 * len(S) - 1]
    spline = BSpline(path.spline.t, fit(path.spline.t, S, line + smooth), DEGREE)
    return Path(path.machine, spline, path.node_s, path.node_pose)
