"""Straight ends: the approach poses where they begin or end, and the task that is left to plan between these.

With `refine.approach_m` L the path leaves the start along `refine.start_direction` d_s up to the pose start + L d_s,
and reaches the goal along `refine.goal_direction` d_g from the pose goal - L d_g, tilted as the ends are. An end
without a direction has no approach.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.config import Config, PoseConfig


@dataclass(frozen=True)
class Approach:
    """The straight end of a path at the start or the goal.

    Attributes
    ----------
    name : str
        "start" or "goal", which is a key of the task.
    end : PoseConfig
        That pose.
    outward : (3,)
        Unit vector from that pose to the approach pose.
    length_m : float
        L.
    """

    name: str
    end: PoseConfig
    outward: tuple[float, float, float]
    length_m: float

    @property
    def title(self) -> str:
        """Name the approach pose."""
        return f"the approach pose of task.{self.name}"

    @property
    def pose(self) -> PoseConfig:
        """The approach pose."""
        return self.pose_at(self.length_m)

    def pose_at(self, distance_m: float) -> PoseConfig:
        """Give the pose at a distance from the end, tilted as it is and in its working mode."""
        x, y, z = (np.array([self.end.x_m, self.end.y_m, self.end.z_m]) + distance_m * np.array(self.outward)).tolist()
        return self.end.model_copy(update={"x_m": x, "y_m": y, "z_m": z})

    def moves(self, steps: FloatArray) -> int:
        """Count the straight moves, none longer along X, Y or Z than the `steps` (5,) of the route."""
        longest = self.length_m * np.abs(self.outward) / steps[:3]
        return max(1, int(np.ceil(longest.max() - 1e-9)))


def approaches(config: Config) -> tuple[Approach, ...]:
    """List the straight ends that `refine.approach_m` asks for, that of the start first."""
    refine, task = config.refine, config.task
    if refine.approach_m is None:
        return ()
    found = []
    for name, end, direction, sense in (
        ("start", task.start, refine.start_direction, 1.0),
        ("goal", task.goal, refine.goal_direction, -1.0),
    ):
        if direction is not None:
            x, y, z = (sense * np.array(direction) / np.linalg.norm(direction)).tolist()
            found.append(Approach(name, end, (x, y, z), refine.approach_m))
    return tuple(found)


def between_approaches(config: Config) -> Config:
    """Give the configuration with approach poses in place of the ends that have one: what stage one plans."""
    ends = {approach.name: approach.pose for approach in approaches(config)}
    if not ends:
        return config
    task, refine = config.task.model_copy(update=ends), config.refine.model_copy(update={"approach_m": None})
    return config.model_copy(update={"task": task, "refine": refine})
