"""What marks the task in the picture: places with a title, and boxes to avoid."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.config import BoxConfig, Config
from pipeline.figures import style
from pipeline.figures.maps.kappa_map import YzWindow
from pipeline.limits.avoid import Box
from pipeline.machine.geometry import Machine

_BEYOND_M = 0.3
"""How far beyond the rails a box is drawn that has no end."""


@dataclass(frozen=True)
class Mark:
    """A place x, y, z in metres, with its title and colour."""

    title: str
    place_m: tuple[float, float, float]
    colour: str


def task_marks(config: Config) -> list[Mark]:
    """Mark start, goal and visits; those at one place share a mark."""
    task = config.task
    poses = [("start", task.start, style.GREEN), ("goal", task.goal, style.GREEN)]
    poses += [(f"visit[{k}]", visit.pose, style.SKY_BLUE) for k, visit in enumerate(task.visit) if visit.pose]
    marks: dict[tuple[float, float, float], Mark] = {}
    for name, pose, colour in poses:
        place = (pose.x_m, pose.y_m, pose.z_m)
        title, before = f"{name} {pose.mode}", marks.get(place)
        marks[place] = Mark(title if before is None else f"{before.title}, {title}", place, colour)
    return list(marks.values())


def shown_box(box: BoxConfig, machine: Machine, window: YzWindow) -> tuple[FloatArray, FloatArray]:
    """Cut a box down to what is shown: least and largest x, y, z, each (3,)."""
    limits, travel = Box.of(box), machine.travel_m
    low = np.maximum(limits.low[:3], [travel[:, 0].min() - _BEYOND_M, window.y_least, window.z_least])
    high = np.minimum(limits.high[:3], [travel[:, 1].max() + _BEYOND_M, window.y_largest, window.z_largest])
    return low, np.maximum(high, low + 1e-3)
