"""What every program of a mesh is written for."""

from collections.abc import Sequence
from dataclasses import dataclass

from pipeline.arrays import FloatArray
from pipeline.limits import NodeLimit, node_limits
from pipeline.limits.actuator_margins import planned_range_m
from pipeline.refine.corridor.cells import Corridor
from pipeline.refine.mesh import Mesh
from pipeline.refine.problem import Problem


@dataclass(frozen=True, eq=False)
class NodeData:
    """What the nodes of a program have to keep.

    Attributes
    ----------
    mesh : Mesh
        Nodes, k of them, and knots.
    corridor : Corridor
        Bounds of the poses.
    limits : sequence of NodeLimit
        What nodes have to keep.
    clearance_margin_m, reach_m : float
        What nodes keep on top of distances, and how near to a limit something has to come to get a row.
    steps : (5,)
        The metric: largest moves per step of the route.
    directions : (2, 5)
        Unit vectors in which the actuators leave the start and reach the goal, NaN where they are free.
    actuator_range_m : (5, 2)
        Least and largest position of every actuator along the path.
    """

    mesh: Mesh
    corridor: Corridor
    limits: Sequence[NodeLimit]
    clearance_margin_m: float
    reach_m: float
    steps: FloatArray
    directions: FloatArray
    actuator_range_m: FloatArray


def node_data(problem: Problem, mesh: Mesh, corridor: Corridor) -> NodeData:
    """Collect what the nodes of a mesh have to keep."""
    config = problem.config
    return NodeData(
        mesh=mesh,
        corridor=corridor,
        limits=node_limits(config, problem.machine),
        clearance_margin_m=config.refine.clearance_margin_m,
        reach_m=float(problem.steps[:3].max()),
        steps=problem.steps,
        directions=problem.directions,
        actuator_range_m=planned_range_m(config, problem.machine),
    )
