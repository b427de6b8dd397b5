"""A period of controllers and machine together, and many of them at a time, as compiled functions."""

from typing import NamedTuple

import casadi as ca
import numpy as np

from pipeline.arrays import FloatArray
from pipeline.machine.geometry import Machine
from pipeline.machine.kinematics import newton
from pipeline.simulate.controller import controller_function, controller_size
from pipeline.simulate.drives import Drives
from pipeline.simulate.motion import steps_of
from pipeline.simulate.plant_step import STATE, plant_step_function, split_state


class Records(NamedTuple):
    """Rows (n, ...) at the beginning of each period; `force` and `grip` act during it."""

    q: FloatArray
    qd: FloatArray
    qdd: FloatArray
    pose: FloatArray
    force: FloatArray
    grip: FloatArray


class Looped:
    """Machine and controllers that go on from where they are, a block of periods at a time.

    Parameters
    ----------
    machine : Machine
        The machine, whose pose is corrected by Newton's method before every block.
    block : casadi.Function
        Of `block_function`.
    state : (STATE,)
        Where the machine begins.
    controller : (k,)
        Where the controllers begin.
    """

    def __init__(self, machine: Machine, block: ca.Function, state: FloatArray, controller: FloatArray) -> None:
        self._machine, self._block = machine, block
        self._state, self._controller = state, controller

    def run(self, reference: FloatArray) -> Records:
        """Run as many periods as a block has, for references (n, 15) in actuators' own positions."""
        now = split_state(self._state)
        now["pose"] = newton(self._machine, now["q"][None], now["pose"][None])[0][0]
        self._state = np.concatenate(list(now.values()))
        states, controllers, during, qdd = (
            np.asarray(part, dtype=float).T for part in self._block(self._state, self._controller, reference.T)
        )
        before = split_state(np.vstack([self._state, states[:-1]]))
        self._state, self._controller = states[-1], controllers[-1]
        acting = split_state(during)
        return Records(before["q"], before["qd"], qdd, before["pose"], acting["force"], acting["grip"])


def block_function(machine: Machine, drives: Drives, period_s: float, rows: int) -> ca.Function:
    """Build (state, controller, references (15, rows)) -> states, controllers, states during it, and qdd.

    A column per period; the machine is integrated in equal steps of at most a millisecond, during which the command
    is held. References are positions and velocities of the machine's own actuators, and forces that are fed forward.

    Raises
    ------
    ValueError
        For a machine without masses.
    """
    steps = steps_of(period_s)
    step = plant_step_function(machine, drives, period_s / steps)
    control = controller_function(drives, period_s)
    state, reference = ca.MX.sym("state", STATE), ca.MX.sym("reference", 15)
    controller = ca.MX.sym("controller", controller_size(drives, period_s))
    command, following = control(state[:5], state[5:10], controller, reference)
    during, qdd = step(state, command)
    after = during
    for _ in range(steps - 1):
        after, _ = step(after, command)
    names = ["state", "controller", "reference"], ["state_next", "controller_next", "during", "qdd"]
    period = ca.Function("period", [state, controller, reference], [after, following, during, qdd], *names)
    return period.mapaccum("block", rows, ["state", "controller"], ["state_next", "controller_next"])


def start_state(q_m: FloatArray, pose: FloatArray, force_n: FloatArray) -> FloatArray:
    """Give the state of a machine at rest, with drives that push with forces (5,), and without friction."""
    return np.concatenate([q_m, np.zeros(5), pose, force_n, np.zeros(5)])
