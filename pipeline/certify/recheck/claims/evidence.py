"""What the boxes of a chain prove of a limit, and what it is compared with."""

from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.config import Config
from pipeline.machine.geometry import Machine


@dataclass(frozen=True, eq=False)
class Evidence:
    """What the configuration asks for, and what was found of one limit.

    Attributes
    ----------
    config, machine : Config, Machine
        The configuration and its machine, from which limits are read.
    found : (m, 2)
        Bounds from below and above over all boxes, infinite on a side without one; NaN where none could be computed.
    """

    config: Config
    machine: Machine
    found: FloatArray

    @property
    def least(self) -> FloatArray:
        """Lower bounds, shape (m,)."""
        return self.found[:, 0]

    @property
    def largest(self) -> FloatArray:
        """Upper bounds, shape (m,)."""
        return self.found[:, 1]


def upper_bounds(values: FloatArray) -> FloatArray:
    """Give bounds from above (m,) as `Evidence` holds them, shape (m, 2)."""
    return np.column_stack([np.full(len(values), -np.inf), values])


def lower_bounds(values: FloatArray) -> FloatArray:
    """Give bounds from below (m,) as `Evidence` holds them, shape (m, 2)."""
    return np.column_stack([values, np.full(len(values), np.inf)])


def combined(found: FloatArray, more: FloatArray) -> FloatArray:
    """Combine bounds over some boxes with those over others, both (m, 2); NaN stays NaN."""
    return np.column_stack([np.minimum(found[:, 0], more[:, 0]), np.maximum(found[:, 1], more[:, 1])])
