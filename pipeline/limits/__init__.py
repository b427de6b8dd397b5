"""Everything a motion has to keep: one module per kind of limit, and the lists that the configuration builds of them.

A new kind of limit is a module with the functions of `LimitKind`, its entry in `KINDS`, and its check in
`certify.recheck` if it is proven.
"""

from pipeline.limits.kinds import (
    KINDS,
    LimitKind,
    measures,
    move_limits,
    node_limits,
    path_limits,
    pose_limits,
    relaxations,
)
from pipeline.limits.limit import Curve, Limit, NodeLimit, ProvenLimit, ShownLimit, Wording, admits, admitted
from pipeline.limits.measures import Measure
from pipeline.limits.relaxation import RegionFilter, Relaxation

__all__ = [
    "KINDS",
    "Curve",
    "Limit",
    "LimitKind",
    "Measure",
    "NodeLimit",
    "ProvenLimit",
    "RegionFilter",
    "Relaxation",
    "ShownLimit",
    "Wording",
    "admits",
    "admitted",
    "measures",
    "move_limits",
    "node_limits",
    "path_limits",
    "pose_limits",
    "relaxations",
]
