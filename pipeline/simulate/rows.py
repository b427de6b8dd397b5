"""A simulated motion summed up: errors, drives, links, working modes and the determinant of H."""

from dataclasses import dataclass
from itertools import zip_longest

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.machine.geometry import ACTUATORS, LINKS, Machine
from pipeline.machine.pose import CONTROLLED
from pipeline.machine.working_modes import mode_names, reach_along_rails, working_modes
from pipeline.measured import ErrorRow, MeasurementComparison, error_rows
from pipeline.retime.quantities import fractions
from pipeline.simulate.result import Simulation


@dataclass(frozen=True)
class DriveRow:
    """A drive: its following error of largest magnitude and when, and its forces, in metres, seconds, newtons.

    Shares are those of the error that trips it, and of its largest force on the side of the force.
    """

    drive: str
    following_error_m: float
    following_error_at_s: float
    trip_m: float
    trip_share: float
    planned_peak_n: float
    peak_n: float
    force_share: float
    saturated_s: float


@dataclass(frozen=True)
class LinkRow:
    """A link: the largest magnitudes of the force along it, planned and simulated, and the share of its limit."""

    link: str
    planned_peak_n: float
    peak_n: float
    largest_difference_n: float
    force_share: float


@dataclass(frozen=True)
class ModeRow:
    """A working mode and when it was entered; None where one of both motions does not have it."""

    mode: str | None
    t_s: float | None
    planned_mode: str | None
    planned_t_s: float | None


@dataclass(frozen=True)
class Determinant:
    """The determinant of H: whether its sign stays that of the plan, and its least part of the planned magnitude."""

    sign_kept: bool
    least_ratio: float
    least_ratio_at_s: float


@dataclass(frozen=True)
class TcpError:
    """Distance between the TCP as commanded and as simulated, in metres."""

    largest_m: float
    largest_at_s: float
    rms_m: float


def comparison(simulation: Simulation) -> MeasurementComparison:
    """Compare the simulated poses with the commanded ones, as measured ones are."""
    commanded = simulation.motion.pose[: len(simulation)]
    return MeasurementComparison(simulation.t_s, commanded[:, CONTROLLED], simulation.pose[:, CONTROLLED], None)


def pose_rows(simulation: Simulation) -> list[ErrorRow]:
    """Sum up the errors of x, y, z, rx and rz."""
    return error_rows(comparison(simulation))


def tcp_error(simulation: Simulation) -> TcpError:
    """Sum up how far the TCP is from where it is commanded to be."""
    distance = np.linalg.norm(simulation.pose_error[:, :3], axis=1)
    worst = int(np.argmax(distance))
    return TcpError(float(distance[worst]), float(simulation.t_s[worst]), float(np.sqrt(np.mean(distance**2))))


def drive_rows(simulation: Simulation) -> list[DriveRow]:
    """Sum up the drives."""
    error, planned = simulation.following_error_m, simulation.motion.drive_n[: len(simulation)]
    worst = np.abs(error).argmax(axis=0)
    shares = fractions(simulation.drive_n, simulation.drives.saturation_n).max(axis=0)
    return [
        DriveRow(
            drive=name,
            following_error_m=float(error[worst[k], k]),
            following_error_at_s=float(simulation.t_s[worst[k]]),
            trip_m=float(simulation.drives.trip_m[k]),
            trip_share=float(np.abs(error[worst[k], k]) / simulation.drives.trip_m[k]),
            planned_peak_n=float(np.abs(planned[:, k]).max()),
            peak_n=float(np.abs(simulation.drive_n[:, k]).max()),
            force_share=float(shares[k]),
            saturated_s=float(simulation.saturated[:, k].sum() * simulation.motion.period_s),
        )
        for k, name in enumerate(ACTUATORS)
    ]


def link_rows(simulation: Simulation) -> list[LinkRow]:
    """Sum up the links."""
    planned = simulation.motion.link_n[: len(simulation)]
    shares = fractions(simulation.link_n, simulation.machine.force_limits_n[:, 5:]).max(axis=0)
    return [
        LinkRow(
            link=name,
            planned_peak_n=float(np.abs(planned[:, k]).max()),
            peak_n=float(np.abs(simulation.link_n[:, k]).max()),
            largest_difference_n=float(np.abs(simulation.link_n[:, k] - planned[:, k]).max()),
            force_share=float(shares[k]),
        )
        for k, name in enumerate(LINKS)
    ]


def mode_rows(simulation: Simulation) -> list[ModeRow]:
    """List the working modes that both motions go through, side by side."""
    motion = simulation.motion
    real = mode_times(simulation.plant.machine, simulation.pose, simulation.q_m, simulation.t_s)
    planned = mode_times(simulation.machine, motion.pose, motion.q_m, motion.t_s)
    rest = (None, None)
    return [ModeRow(*one, *other) for one, other in zip_longest(real, planned, fillvalue=rest)]


def mode_times(machine: Machine, pose: FloatArray, q_m: FloatArray, t_s: FloatArray) -> list[tuple[str, float]]:
    """List the working modes of a motion, poses (n, 6), actuators (n, 5), with the times (n,) when they are entered."""
    modes = working_modes(reach_along_rails(machine, pose, q_m[:, :3]))
    entered = np.concatenate([[0], 1 + np.flatnonzero((np.diff(modes, axis=0) != 0.0).any(axis=1))])
    return [(name, float(t)) for name, t in zip(mode_names(modes[entered]), t_s[entered], strict=True)]


def determinant(simulation: Simulation) -> Determinant:
    """Compare det H of the real machine with the plan's."""
    ratio = simulation.det_h / simulation.planned_det_h
    least = int(np.argmin(ratio))
    return Determinant(bool((ratio > 0.0).all()), float(ratio[least]), float(simulation.t_s[least]))
