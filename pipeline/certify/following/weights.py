"""The following errors that are searched: of all actuators alike, in the ratio of their velocities, of each alone."""

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.machine.geometry import ACTUATORS, Machine

COMMON = "common"
BY_VELOCITY = "by_velocity"


def following_weights(machine: Machine) -> dict[str, FloatArray]:
    """Give the errors (5,) of every kind relative to the largest one.

    Actuators that are late by the same time in every way of moving are off in the ratio of their velocity limits; which
    of them is early, and which is late, is left open.
    """
    alone = dict(zip(ACTUATORS, np.eye(len(ACTUATORS)), strict=True))
    fastest = float(machine.velocity_mps.max())
    by_velocity = {BY_VELOCITY: machine.velocity_mps / fastest} if fastest > 0.0 else {}
    return {COMMON: np.ones(len(ACTUATORS)), **by_velocity, **alone}
