"""The check between the nodes: what the program promises at nodes must hold on the whole path."""

from dataclasses import dataclass

import numpy as np

from pipeline.config import Config
from pipeline.errors import ForwardKinematicsError
from pipeline.machine.geometry import FloatArray
from pipeline.refine.measure import PathSamples, sample_path
from pipeline.refine.result import Path

_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class Breach:
    """A promise broken somewhere: what, by how much at worst, and at which s (n,)."""

    what: str
    worst: float
    s: FloatArray

    def __str__(self) -> str:
        return f"{self.what} (worst {self.worst:.4g}, first at s = {self.s[0]:.4f})"


def breaches(config: Config, path: Path) -> list[Breach]:
    """Sample a path densely and list what it breaks: det H, kappa, clearance, tilt, strokes and travel."""
    s = np.linspace(0.0, 1.0, config.refine.check_points + 1)
    try:
        samples = sample_path(path, s)
    except ForwardKinematicsError as error:
        return [Breach("the closure equations have no solution", error.residual_m, s[[error.index]])]
    machine, q = path.machine, samples.q_m
    limits = machine.actuator_limits_m
    outside = np.maximum(limits[:, 0] - q, q - limits[:, 1]).max(axis=1)
    tilt = np.rad2deg(np.abs(samples.pose[:, [3, 5]]))
    allowed = np.array(
        [
            config.refine.lock_tolerance_deg if axis in config.task.locked_axes else config.task.tilt_max_deg
            for axis in ("rx", "rz")
        ]
    )
    excesses = {
        "det H changes sign": np.where(samples.det_sign == samples.det_sign[0], 0.0, 1.0),
        "kappa above route.kappa_max": samples.kappa - config.route.kappa_max,
        "links too close, metres": machine.link_link_m - samples.link_distance_m,
        "a link too close to a rail, metres": _unless_unchecked(machine.link_rail_m - samples.rail_distance_m),
        "tilt too large, degrees": (tilt - allowed).max(axis=1),
        "actuators beyond stroke or travel, metres": outside,
        "the pose jumps": _jumps(samples),
    }
    return [
        Breach(what, float(excess.max()), s[excess > _ROUNDING])
        for what, excess in excesses.items()
        if (excess > _ROUNDING).any()
    ]


def _unless_unchecked(excess: FloatArray) -> FloatArray:
    return np.nan_to_num(excess, nan=-1.0)


def _jumps(samples: PathSamples) -> FloatArray:
    """Moves between neighbouring samples far beyond the usual: another branch of the forward kinematics."""
    moves = np.abs(np.diff(samples.pose, axis=0, prepend=samples.pose[:1])).max(axis=1)
    return np.where(moves > 20.0 * np.median(moves) + 1e-6, moves, 0.0)
