"""The machine in motion: where its joints are at instants close enough for the eye, and kappa around it at fewer."""

import math

import numpy as np
from contourpy import LineType, contour_generator
from scipy.spatial import ConvexHull

from pipeline.arrays import FloatArray, IntArray
from pipeline.config import Config
from pipeline.figures.maps.kappa_map import KappaMap, YzWindow, kappa_map, seen_window
from pipeline.machine.geometry import MODES, Machine, cart_joints, platform_arms
from pipeline.machine.statics import condition_number, statics_matrix
from pipeline.machine.working_modes import mode_names, reach_along_rails, working_modes
from pipeline.report.data import KappaMaps, Motion, MotionName, Scene
from pipeline.retime.result import Trajectory, TrajectorySamples
from pipeline.retime.sampling import whole_periods

_FRAMES_PER_S = 50.0
_FEWEST_FRAMES, _MOST_FRAMES = 100, 600
_MAPS = 40
_POINTS_Y, _POINTS_Z = 84, 68
_TILTS = [3, 5]


def build_scene(machine: Machine) -> Scene:
    """Collect what does not move."""
    return Scene(
        rails_m=np.stack([np.column_stack([machine.travel_m[:, end], machine.rails_m]) for end in (0, 1)], axis=1),
        platform_faces=_platform_faces(machine),
        q_limits_m=machine.actuator_limits_m,
        qd_limits_mps=machine.velocity_mps,
    )


def _platform_faces(machine: Machine) -> IntArray:
    """Triangulate the hull of TCP and joints; points on one plane, or one line, are joggled so that there is a hull."""
    points = np.vstack([np.zeros(3), machine.platform_points_m])
    faces: IntArray = ConvexHull(points, qhull_options="QJ").simplices
    return faces


def build_motion(config: Config, trajectory: Trajectory, name: MotionName) -> Motion:
    """Look at a trajectory at evenly spaced instants; it lasts whole periods, as the controller drives it.

    Raises
    ------
    ForwardKinematicsError
        Where the closure equations have no solution near the path's known poses.
    """
    machine = trajectory.path.machine
    trajectory = whole_periods(trajectory, config.retime.period_s)
    frames = int(np.clip(math.ceil(trajectory.duration_s * _FRAMES_PER_S), _FEWEST_FRAMES, _MOST_FRAMES))
    samples = _samples(trajectory, np.linspace(0.0, trajectory.duration_s, frames + 1))
    carts = samples.q_m[:, :3]
    reach = reach_along_rails(machine, samples.pose, carts)
    modes = np.array([MODES.index(mode) for mode in mode_names(working_modes(reach))])
    return Motion(
        name=name,
        t_s=samples.t_s,
        kappa=samples.kappa,
        pose=samples.pose,
        q_m=samples.q_m,
        qd_mps=samples.qd_mps,
        modes=modes,
        feet_m=np.concatenate([carts[:, :, None], np.broadcast_to(machine.rails_m, (len(carts), 3, 2))], axis=2),
        cart_joints_m=cart_joints(machine, carts),
        platform_joints_m=samples.pose[:, None, :3] + platform_arms(machine, samples.pose),
        maps=_maps(config, machine, samples, modes),
    )


def _samples(trajectory: Trajectory, t_s: FloatArray) -> TrajectorySamples:
    """Evaluate a trajectory at any instants (n,)."""
    q, pose = trajectory.q(t_s), trajectory.pose(t_s)
    return TrajectorySamples(
        period_s=float(t_s[1] - t_s[0]),
        t_s=t_s,
        q_m=q,
        qd_mps=trajectory.q(t_s, 1),
        qdd_mps2=trajectory.q(t_s, 2),
        pose=pose,
        kappa=condition_number(statics_matrix(trajectory.path.machine, pose, q[:, :3])),
    )


def _maps(config: Config, machine: Machine, samples: TrajectorySamples, modes: IntArray) -> KappaMaps:
    """Map kappa at some instants; all maps show the same part of the plane."""
    at = _instants(modes)
    tilts = samples.pose[at][:, _TILTS]
    window = seen_window(config.route.grid, machine, tilts, modes[at], [samples.pose[:, 1:3]])
    y_m, z_m = _grid(window)
    maps = [
        kappa_map(machine, y_m, z_m, (float(rx), float(rz)), int(mode))
        for (rx, rz), mode in zip(tilts, modes[at], strict=True)
    ]
    return KappaMaps(
        t_s=samples.t_s[at],
        modes=modes[at],
        y_m=y_m,
        z_m=z_m,
        kappa=np.stack([one.kappa for one in maps]),
        loops=tuple(singular_loops(one) for one in maps),
        titles=tuple(_title(tilt, int(mode)) for tilt, mode in zip(tilts, modes[at], strict=True)),
        kappa_cap=config.route.kappa_max,
    )


def _instants(modes: IntArray) -> IntArray:
    """Choose samples evenly, and both sides of every change of working mode: the map changes at once there."""
    evenly = np.linspace(0, len(modes) - 1, _MAPS).round().astype(np.int64)
    changes = np.flatnonzero(np.diff(modes))
    instants: IntArray = np.unique(np.concatenate([evenly, changes, changes + 1]))
    return instants


def _grid(window: YzWindow) -> tuple[FloatArray, FloatArray]:
    y = np.linspace(window.y_least, window.y_largest, _POINTS_Y)
    z = np.linspace(window.z_least, window.z_largest, _POINTS_Z)
    return y, z


def singular_loops(a_map: KappaMap) -> FloatArray:
    """Trace the curves det H = 0 of a map: y and z (m, 2), a row of NaN after every curve.

    Only cells wholly in reach count: signs that differ across a gap prove nothing.
    """
    if not a_map.has_singularities:
        return np.empty((0, 2))
    det = np.ma.masked_invalid(a_map.det)
    lines = contour_generator(a_map.y_m, a_map.z_m, det, corner_mask=False, line_type=LineType.Separate).lines(0.0)
    gap = np.full((1, 2), np.nan)
    return np.concatenate([part for line in lines for part in (np.asarray(line), gap)])


def _title(tilt: FloatArray, mode: int) -> str:
    rx, rz = (f"{round(float(angle), 1) + 0.0:.1f}°".replace("-", "−") for angle in np.rad2deg(tilt))
    return f"{MODES[mode]}, rx {rx}, rz {rz}"
