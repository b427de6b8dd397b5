"""Routes between all pairs of stations, over one region table and one set of moves."""

from pipeline.atlas.graph import AtlasGraph, build_graph
from pipeline.atlas.plan import AtlasEntry, plan_pairs
from pipeline.atlas.stations import Station, atlas_stations, pair_config, require_stations

__all__ = [
    "AtlasEntry",
    "AtlasGraph",
    "Station",
    "atlas_stations",
    "build_graph",
    "pair_config",
    "plan_pairs",
    "require_stations",
]
