"""Machines whose rails are off X."""

from dataclasses import replace

import numpy as np

from pipeline.machine import Machine


def off_x(machine: Machine, seed: int = 1, largest: float = 0.05) -> Machine:
    """Give every rail a direction of its own; by default much farther off than a configuration allows."""
    slopes = np.random.default_rng(seed).uniform(-largest, largest, (3, 2))
    along = np.column_stack([np.ones(3), slopes])
    return replace(machine, rail_directions=along / np.linalg.norm(along, axis=1, keepdims=True))
