"""The machine in motion: joints and bodies at 50 instants per second, maps of kappa around it at fewer instants."""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from contourpy import LineType, contour_generator

from pipeline.arrays import FloatArray, IntArray
from pipeline.config import Config
from pipeline.figures.maps.kappa_map import KappaMap, YzWindow, kappa_map, seen_window
from pipeline.limits.bodies.obstacle_distance import obstacles_of
from pipeline.limits.bodies.pairs import kept_apart, pair_names
from pipeline.machine.bodies.distances import body_distances
from pipeline.machine.bodies.meshes import body_meshes
from pipeline.machine.drawing import drawn_points, platform_bars, rail_ends
from pipeline.machine.geometry import MODES, Machine
from pipeline.machine.pose import TILT_COLUMNS
from pipeline.machine.samples import PoseSamples
from pipeline.machine.statics import moment_unit
from pipeline.machine.working_modes import mode_names, reach_along_rails, working_modes
from pipeline.report.data import KappaMaps, Motion, MotionName, NearestPairs, Scene
from pipeline.retime.result import Trajectory, TrajectorySamples
from pipeline.retime.sampling import sample_at, whole_periods

_FRAMES_PER_S = 50.0
_FEWEST_FRAMES, _MOST_FRAMES = 100, 600
_MAPS = 30
_POINTS_Y, _POINTS_Z = 84, 68
_ALARM_M = 0.005
"""The nearest pair is red below twice the distance that is required, and below that and this much."""


def build_scene(config: Config, machine: Machine) -> Scene:
    """Collect what does not move, and the shapes of what does."""
    scene = Scene(
        rails_m=rail_ends(machine),
        platform_bars=platform_bars(machine),
        q_limits_m=machine.actuator_limits_m,
        qd_limits_mps=machine.velocity_mps,
        moment_unit=moment_unit(machine),
    )
    if not (kept := kept_apart(config, machine)):
        return scene
    meshes, least = body_meshes(machine, obstacles_of(config)), kept[0].clearance_m
    drawn = {mesh.name: number for number, mesh in enumerate(meshes)}
    pairs = [[drawn.get(bodies.hulls[k].name, -1) for k in pair] for bodies in kept for pair in bodies.pairs]
    return replace(
        scene,
        meshes=meshes,
        pairs=tuple((first, second) for first, second in pairs),
        pair_names=pair_names(kept),
        clearance_m=least,
        alarm_m=least + max(least, _ALARM_M),
    )


def build_motion(config: Config, trajectory: Trajectory, name: MotionName) -> Motion:
    """Evaluate a trajectory at evenly spaced instants; its duration is whole periods, as the controller drives it.

    Raises
    ------
    ForwardKinematicsError
        Where the closure equations have no solution near the path's known poses.
    """
    machine = trajectory.path.machine
    trajectory = whole_periods(trajectory, config.retime.period_s)
    frames = int(np.clip(math.ceil(trajectory.duration_s * _FRAMES_PER_S), _FEWEST_FRAMES, _MOST_FRAMES))
    t = np.linspace(0.0, trajectory.duration_s, frames + 1)
    samples = sample_at(trajectory, t, float(t[1] - t[0]))
    reach = reach_along_rails(machine, samples.pose, samples.q_m[:, :3])
    modes = np.array([MODES.index(mode) for mode in mode_names(working_modes(reach))])
    points = drawn_points(machine, samples.pose, samples.q_m)
    motion = Motion(
        name=name,
        t_s=samples.t_s,
        kappa=samples.kappa,
        pose=samples.pose,
        q_m=samples.q_m,
        qd_mps=samples.qd_mps,
        modes=modes,
        feet_m=points.feet_m,
        cart_joints_m=points.cart_joints_m,
        platform_joints_m=points.platform_joints_m,
        maps=_maps(config, machine, samples, modes),
    )
    return replace(motion, nearest=tuple(_nearest(config, PoseSamples(machine, samples.pose, samples.q_m))))


def _nearest(config: Config, samples: PoseSamples) -> Iterator[NearestPairs]:
    """Find the nearest pair of bodies at each instant, and that of bodies and obstacles."""
    before = 0
    for bodies in kept_apart(config, samples.machine):
        distances = body_distances(bodies, samples)
        of = "bodies" if bodies is samples.machine.bodies else "obstacles"
        yield NearestPairs(of, before + distances.argmin(axis=1), distances.min(axis=1))
        before += len(bodies.pairs)


def _maps(config: Config, machine: Machine, samples: TrajectorySamples, modes: IntArray) -> KappaMaps:
    """Map kappa at some instants, all over the same part of the plane."""
    at = _instants(modes)
    tilts = samples.pose[at][:, TILT_COLUMNS]
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
        colour_limit=config.route.kappa_max,
    )


def _instants(modes: IntArray) -> IntArray:
    """Choose samples evenly, and on both sides of every change of working mode, where the map jumps."""
    evenly = np.linspace(0, len(modes) - 1, _MAPS).round().astype(np.int64)
    changes = np.flatnonzero(np.diff(modes))
    return np.unique(np.concatenate([evenly, changes, changes + 1]))


def _grid(window: YzWindow) -> tuple[FloatArray, FloatArray]:
    y = np.linspace(window.y_least, window.y_largest, _POINTS_Y)
    z = np.linspace(window.z_least, window.z_largest, _POINTS_Z)
    return y, z


def singular_loops(a_map: KappaMap) -> FloatArray:
    """Trace the curves det H = 0 of a map: y and z (m, 2), with a row of NaN after every curve.

    Only cells completely in reach count: different signs on both sides of a gap prove nothing.
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
