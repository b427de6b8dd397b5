"""Stage one: which regions, which working modes; a mixed-integer program over a proven core."""

from pipeline.route.ends import End, task_ends
from pipeline.route.planner import plan_route, plan_routes
from pipeline.route.regions import RegionTable, build_regions, grid_regions
from pipeline.route.result import Route, Search

__all__ = [
    "End",
    "RegionTable",
    "Route",
    "Search",
    "build_regions",
    "grid_regions",
    "plan_route",
    "plan_routes",
    "task_ends",
]
