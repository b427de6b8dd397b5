"""The least distance between the axes of links that share no joint."""

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.config import Config
from pipeline.limits.axis_distance import DISTANCE, AxisDistance, distance_relaxation
from pipeline.limits.interface.limit import Limit, Wording
from pipeline.limits.interface.measure import Measure
from pipeline.limits.interface.proof import CertificateEntry
from pipeline.limits.interface.relaxation import Relaxation
from pipeline.machine.clearance import link_pairs
from pipeline.machine.geometry import Machine
from pipeline.machine.samples import PoseSamples

_KEY = "machine.clearance.link_link_m"


def _distances(samples: PoseSamples) -> FloatArray:
    return samples.link_distances_m


def for_poses(machine: Machine, kappa_max: float) -> list[Limit]:
    """Return the limit of poses by themselves: none if links have bodies instead."""
    if np.isnan(machine.link_link_m):
        return []
    wording = Wording(
        name="link-link distance",
        key=_KEY,
        rejected_move="links come too close",
        refused_points=f"have links closer than {_KEY} ({machine.link_link_m:g})",
        broken_path="links too close, metres",
        path_advice="Raise refine.clearance_margin_m or refine.nodes.",
        proof_advice="Raise refine.clearance_margin_m.",
    )
    return [AxisDistance(machine.link_link_m, link_pairs(machine), False, _distances, wording, cost=1)]


def for_moves(config: Config, machine: Machine) -> list[Limit]:
    """Return the limit of moves between regions."""
    return for_poses(machine, config.route.kappa_max)


def for_path(config: Config, machine: Machine) -> list[Limit]:
    """Return the limit of a path."""
    return for_poses(machine, config.route.kappa_max)


def relaxations(config: Config, machine: Machine) -> list[Relaxation]:
    """Return smaller distances down to zero; none if links have bodies instead."""
    return [] if np.isnan(machine.link_link_m) else distance_relaxation(config, "link_link_m", _distances)


CERTIFICATE = CertificateEntry((DISTANCE,))
MEASURES: tuple[Measure, ...] = (
    Measure(
        key="min_link_distance_m",
        name="least link-link distance",
        unit="m",
        prefers="higher",
        resolution=1e-5,
        reduce=lambda samples: float(samples.link_distances_m.min()),
    ),
)
