"""Simulated measurements to calibrate from."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
from scipy.interpolate import PPoly

from pipeline.arrays import FloatArray
from pipeline.calibrate import DrivenMotion, StaticSetting, simulate_static
from pipeline.calibrate.calibration import Setting, build_problem
from pipeline.calibrate.data.simulated import SimulatedPoses
from pipeline.calibrate.estimate.frame import fit_frame
from pipeline.calibrate.identify import Problem
from pipeline.calibrate.model.forward import close, positions
from pipeline.calibrate.model.model import Model, configured_model
from pipeline.config import Config
from pipeline.machine import build_machine
from pipeline.machine.actuator_space.controller_units import controller_units
from pipeline.retime.result import Trajectory
from tests.reference import reference_path

MOTION_S, PERIOD_S = 6.0, 0.03
REFLECTORS_M = np.array([[0.0, 0.10, 0.05], [0.0, 0.40, 0.05], [0.15, 0.25, -0.05]])


@dataclass(frozen=True, eq=False)
class Seen:
    """A simulated measurement, and the machine as configured in the frame of the tracker that is estimated first."""

    simulated: SimulatedPoses
    configured: Model
    guess: FloatArray

    def problem(self, setting: Setting) -> Problem:
        """Pose the identification, with the assembly of every pose known."""
        points = positions(self.configured, close(self.configured, self.simulated.poses.q_m, self.guess))
        seen = self.simulated.poses.is_seen
        frame = fit_frame(points[seen], self.simulated.poses.seen_m[seen])
        model = self.configured.with_frame(frame.rotation, frame.translation_m)
        return build_problem(model, self.simulated.poses, self.guess, setting)


@pytest.fixture(scope="session")
def driven(quick_config: Config) -> DrivenMotion:
    """Drive the reference motion gently from rest to rest: s = 3 u^2 - 2 u^3 with u = t / T."""
    law = PPoly(np.array([[-2.0 / MOTION_S**3], [3.0 / MOTION_S**2], [0.0], [0.0]]), [0.0, MOTION_S])
    path = reference_path(build_machine(quick_config.machine))
    return DrivenMotion(Trajectory(path, law), controller_units(quick_config.machine), PERIOD_S)


@pytest.fixture(scope="session")
def see(quick_config: Config) -> Callable[..., Seen]:
    """Give a function that simulates a measurement with so many reflectors, each only once."""

    @cache
    def measure(reflectors: int = 2, **setting: float) -> Seen:
        places = REFLECTORS_M[:reflectors]
        simulated = simulate_static(quick_config, places, StaticSetting(**setting))
        configured = configured_model(quick_config.machine, places)
        guess = close(configured, simulated.poses.q_m, simulated.configured_pose).pose
        return Seen(simulated, configured, guess)

    return measure
