"""The least distance between links and the rails of the other arms, taken as endless lines."""

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.config import Config
from pipeline.limits.axis_distance import DISTANCE, AxisDistance, distance_relaxation
from pipeline.limits.interface.limit import Limit, Wording
from pipeline.limits.interface.measure import Measure
from pipeline.limits.interface.proof import CertificateEntry
from pipeline.limits.interface.relaxation import Relaxation
from pipeline.machine.clearance import link_rail_distances, rail_pairs
from pipeline.machine.geometry import Machine
from pipeline.machine.samples import PoseSamples

_KEY = "machine.clearance.link_rail_m"


def _distances(samples: PoseSamples) -> FloatArray:
    return link_rail_distances(samples.machine, samples.pose, samples.carts_m)


def for_poses(machine: Machine, kappa_max: float) -> list[Limit]:
    """Return the limit of poses by themselves: none if rails are not checked."""
    if np.isnan(machine.link_rail_m):
        return []
    wording = Wording(
        name="link-rail distance",
        key=_KEY,
        rejected_move="a link comes too close to a rail",
        refused_points=f"have a link closer to a rail than {_KEY}",
        broken_path="a link too close to a rail, metres",
        path_advice="Raise refine.clearance_margin_m or refine.nodes.",
        proof_advice="Raise refine.clearance_margin_m.",
    )
    return [AxisDistance(machine.link_rail_m, rail_pairs(machine), True, _distances, wording, cost=3)]


def for_moves(config: Config, machine: Machine) -> list[Limit]:
    """Return the limit of moves between regions."""
    return for_poses(machine, config.route.kappa_max)


def for_path(config: Config, machine: Machine) -> list[Limit]:
    """Return the limit of a path."""
    return for_poses(machine, config.route.kappa_max)


def relaxations(config: Config, machine: Machine) -> list[Relaxation]:
    """Return smaller distances down to zero; none if rails are not checked."""
    return [] if np.isnan(machine.link_rail_m) else distance_relaxation(config, "link_rail_m", _distances)


CERTIFICATE = CertificateEntry((DISTANCE,))
MEASURES: tuple[Measure, ...] = (
    Measure(
        key="min_rail_distance_m",
        name="least link-rail distance",
        unit="m",
        prefers="higher",
        resolution=1e-5,
        reduce=lambda samples: float(_distances(samples).min()),
    ),
)
