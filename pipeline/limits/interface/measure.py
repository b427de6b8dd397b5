"""What is measured of a path in the units of its limits, whether or not a limit is configured."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from pipeline.machine.geometry import Machine
from pipeline.machine.samples import PoseSamples


@dataclass(frozen=True)
class Measure:
    """A figure of a sampled path.

    Attributes
    ----------
    key : str
        Its key in the path's section of summary.json.
    name, unit : str
        Its name and unit in comparisons.
    prefers : str
        Whether a lower or a higher value is better.
    resolution : float
        Difference below which two values count as equal.
    reduce : callable
        Reduces samples of a path to the figure.
    applies : callable
        Tells whether there is such a figure of a machine at all.
    """

    key: str
    name: str
    unit: str
    prefers: Literal["lower", "higher"]
    resolution: float
    reduce: Callable[[PoseSamples], float]
    applies: Callable[[Machine], bool] = lambda machine: True
