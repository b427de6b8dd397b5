"""Singularity-free assembly-mode reconfiguration of 5-DOF Gantry-Tau machines, from a YAML file to the controller.

The names below are the public interface; heavy libraries are loaded when a name is first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pipeline.artifacts.path_file import load_path, save_path
    from pipeline.certify import Certificate, certify_path
    from pipeline.config import Config
    from pipeline.config_file import load_config
    from pipeline.machine import Machine, build_machine
    from pipeline.refine import Path, Refinement, kappa_along, pose_derivatives, pose_spline, refine_path
    from pipeline.retime import Trajectory, retime_path, sample_trajectory
    from pipeline.route import RegionTable, Route, build_regions, plan_route, plan_routes

_HOME = {
    "Certificate": "certify",
    "certify_path": "certify",
    "Config": "config",
    "load_config": "config_file",
    "load_path": "artifacts.path_file",
    "save_path": "artifacts.path_file",
    "Machine": "machine",
    "build_machine": "machine",
    "RegionTable": "route",
    "Route": "route",
    "build_regions": "route",
    "plan_route": "route",
    "plan_routes": "route",
    "Path": "refine",
    "Refinement": "refine",
    "kappa_along": "refine",
    "pose_derivatives": "refine",
    "pose_spline": "refine",
    "refine_path": "refine",
    "Trajectory": "retime",
    "retime_path": "retime",
    "sample_trajectory": "retime",
}

__all__ = [
    "Certificate",
    "Config",
    "Machine",
    "Path",
    "Refinement",
    "RegionTable",
    "Route",
    "Trajectory",
    "build_machine",
    "build_regions",
    "certify_path",
    "kappa_along",
    "load_config",
    "load_path",
    "plan_route",
    "plan_routes",
    "pose_derivatives",
    "pose_spline",
    "refine_path",
    "retime_path",
    "sample_trajectory",
    "save_path",
]


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
