"""Regions: every admissible pose and working mode of the grid, gates, and what the task adds."""

from pipeline.route.regions.build import build_regions, grid_regions
from pipeline.route.regions.endpoints import Endpoint, task_endpoints
from pipeline.route.regions.table import RegionTable

__all__ = ["Endpoint", "RegionTable", "build_regions", "grid_regions", "task_endpoints"]
