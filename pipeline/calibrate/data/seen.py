"""What a tracker sees of a machine at measured poses, of static ones and along motions, with its clock offsets."""

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.calibrate.data.poses import StaticPoses
from pipeline.calibrate.model.forward import Closed, close, position_jacobian
from pipeline.calibrate.model.model import Model
from pipeline.calibrate.model.parameters import CLOCKS, ZEROS


def close_at(model: Model, poses: StaticPoses, guess: FloatArray) -> Closed:
    """Assemble a machine where its encoders were at measured poses, with its clock offsets, near guesses (n, 6)."""
    return close(model, poses.encoders(model.clocks_s), guess)


def seen_jacobian(model: Model, poses: StaticPoses, closed: Closed) -> FloatArray:
    """Differentiate where reflectors are seen by all parameters, clock offsets among them.

    A clock that is late by tau shows the encoders of t - tau: dm / d tau = -sum_k dm / dq_k qd_k, and an encoder moves
    its actuator by its scale, as the actuator's zero moves it by one. Shape (n, reflectors, 3, count).
    """
    J = position_jacobian(model, poses.encoders(model.clocks_s), closed)
    if poses.timing is not None:
        rates = model.scales * poses.encoder_rates(model.clocks_s)
        by_clock = -np.einsum("nrik,nk->nri", model.parameters.of(ZEROS, J), rates)
        first = model.parameters.slice(CLOCKS).start
        for motion in range(poses.motions):
            rows = poses.timing.motion == motion
            J[rows, ..., first + motion] = by_clock[rows]
    return J
