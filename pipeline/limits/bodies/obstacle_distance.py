"""The least distance of everything that moves from what is fixed in space: `task.obstacles`, bodies of the frame.

Distances depend on x: regions have windows of x without collision (`route.regions.obstacles`).
"""

from dataclasses import replace
from functools import partial

from pipeline.config import Config
from pipeline.limits.bodies.obstruction import obstruction
from pipeline.limits.bodies.surface_distance import SurfaceDistance
from pipeline.limits.interface.limit import Limit
from pipeline.limits.interface.measure import Measure
from pipeline.limits.interface.proof import CertificateEntry, CertificateKey, Side
from pipeline.limits.interface.relaxation import Relaxation, removals
from pipeline.machine.geometry import Machine
from pipeline.machine.shapes.model import Bodies
from pipeline.machine.shapes.obstacles import build_obstacles

OBSTACLE_DISTANCE = CertificateKey(
    "obstacle_distance_m", Side.LEAST, None, "least distance from obstacles", "m", 5, optional=True
)
NAME = "obstacle distance"


def obstacles_of(config: Config) -> Bodies | None:
    """Build the pairs of what moves and what is fixed in space; None if nothing is."""
    return build_obstacles(config.machine, config.task.obstacles)


def for_poses(machine: Machine, kappa_max: float) -> list[Limit]:
    """Return no limit: obstacles cut the x windows of regions."""
    return []


def for_moves(config: Config, machine: Machine) -> list[Limit]:
    """Return the limit of moves between regions, for poses with an x of their own."""
    pairs = obstacles_of(config)
    return [] if pairs is None else [SurfaceDistance(pairs, OBSTACLE_DISTANCE, NAME, "obstacles and bodies")]


def for_path(config: Config, machine: Machine) -> list[Limit]:
    """Return the limit of a path."""
    return for_moves(config, machine)


def relaxations(config: Config, machine: Machine) -> list[Relaxation]:
    """Remove all obstacles of the task, and each one alone."""
    found, pairs, obstacles = removals(config, "obstacles"), obstacles_of(config), config.task.obstacles
    if pairs is None:
        return found
    entries = [obstacles] * (len(found) - len(obstacles)) + [(one,) for one in obstacles]
    return [
        replace(one, obstruction=partial(obstruction, pairs, {obstacle.name for obstacle in some}))
        for one, some in zip(found, entries, strict=True)
    ]


def _premises(config: Config) -> dict[str, object]:
    """Give the obstacles of the task; those of the frame are among the machine's bodies."""
    found = config.task.model_dump(mode="json", include={"obstacles"})
    return {"obstacles": found["obstacles"]} if found else {}


CERTIFICATE = CertificateEntry((OBSTACLE_DISTANCE,), _premises)
MEASURES: tuple[Measure, ...] = ()
