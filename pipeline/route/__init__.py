"""Stage one: which regions, which working modes; a mixed-integer program over a proven core."""

from pipeline.route.planner import plan_route, plan_routes
from pipeline.route.regions.build import RegionTable, build_regions, grid_regions
from pipeline.route.regions.endpoints import Endpoint, task_endpoints
from pipeline.route.result import Route, Search

__all__ = [
    "Endpoint",
    "RegionTable",
    "Route",
    "Search",
    "build_regions",
    "grid_regions",
    "plan_route",
    "plan_routes",
    "task_endpoints",
]
