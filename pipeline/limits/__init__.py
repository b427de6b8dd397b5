"""Everything a motion has to keep: one module per kind of limit, and the lists that the configuration builds of them.

A new kind of limit is a module with the functions of `LimitKind`, its entry in `KINDS`, and its check in
`certify.recheck` if it is proven.
"""

from pipeline.limits.interface.direction import DirectedLimit, applying, counting, end_stretches
from pipeline.limits.interface.limit import (
    Curve,
    DivisibleLimit,
    ErrorProvenLimit,
    Limit,
    NodeLimit,
    ProvenLimit,
    RoughlyProvenLimit,
    ShownLimit,
    Wording,
    admits,
    admitted,
)
from pipeline.limits.interface.measure import Measure
from pipeline.limits.interface.proof import CertificateEntry, CertificateKey, ProvenQuantity, Side
from pipeline.limits.interface.readings import Reading, ReadLimit, read_limits, read_measures
from pipeline.limits.interface.relaxation import RegionFilter, Relaxation
from pipeline.limits.kinds import (
    KINDS,
    LimitKind,
    certificate_keys,
    error_proven_limits,
    measures,
    move_limits,
    node_limits,
    path_limits,
    pose_limits,
    proven_limits,
    relaxations,
    task_pose_limits,
    unlimited_measures,
)

__all__ = [
    "KINDS",
    "CertificateEntry",
    "CertificateKey",
    "Curve",
    "DirectedLimit",
    "DivisibleLimit",
    "ErrorProvenLimit",
    "Limit",
    "LimitKind",
    "Measure",
    "NodeLimit",
    "ProvenLimit",
    "ProvenQuantity",
    "ReadLimit",
    "Reading",
    "RegionFilter",
    "Relaxation",
    "RoughlyProvenLimit",
    "ShownLimit",
    "Side",
    "Wording",
    "admits",
    "admitted",
    "applying",
    "certificate_keys",
    "counting",
    "end_stretches",
    "error_proven_limits",
    "measures",
    "move_limits",
    "node_limits",
    "path_limits",
    "pose_limits",
    "proven_limits",
    "read_limits",
    "read_measures",
    "relaxations",
    "task_pose_limits",
    "unlimited_measures",
]
