"""Simulated measurements: a machine that differs a little from its model drives, and a noisy tracker measures it."""

from dataclasses import dataclass

import numpy as np

from pipeline.arguments import require_array, require_number, require_one_length, require_whole
from pipeline.arrays import BoolArray, FloatArray
from pipeline.machine.geometry import Machine
from pipeline.machine.kinematics import forward_kinematics
from pipeline.measured.perturbed import generators, perturbed
from pipeline.measured.reflectors import Reflectors, reflector_positions

_OUTLIER_M = 0.05


@dataclass(frozen=True)
class SimulationSetting:
    """How far the machine is from its model, and which random numbers are drawn.

    Attributes
    ----------
    geometry_std_m : float
        Standard deviation of every coordinate of every joint, of y and z of every rail, of the length of every fixed
        link and of the zero of every telescope; independent, drawn once.
    seed : int
        The same seed gives the same measurement.
    outliers : float
        Part of the points that are 50 mm off.

    Raises
    ------
    ArgumentError
        When the standard deviation is negative or not finite, the seed negative or not a whole number, or outliers are
        more than half.
    """

    geometry_std_m: float = 2e-4
    seed: int = 0
    outliers: float = 0.0

    def __post_init__(self) -> None:
        require_number("geometry_std_m", self.geometry_std_m, least=0.0)
        require_number("outliers", self.outliers, least=0.0, largest=0.5)
        require_whole("seed", self.seed, 0, 2**53)


def simulate_measurement(
    machine: Machine, q_m: FloatArray, commanded: FloatArray, reflectors: Reflectors, setting: SimulationSetting
) -> FloatArray:
    """Simulate both reflectors while a perturbed machine drives actuators (n, 5), near commanded poses (n, 6).

    The pose is that of the perturbed machine, by forward kinematics; noise is added. Shape (n, 2, 3).

    Raises
    ------
    ArgumentError
        When actuators or poses have other shapes or hold what is no finite number.
    ForwardKinematicsError
        When the perturbed machine cannot follow.
    """
    q_m, commanded = require_array("q_m", q_m, ("n", 5)), require_array("commanded", commanded, ("n", 6))
    require_one_length(q_m=q_m, commanded=commanded)
    geometry, noise = generators(setting.seed)
    real, zeros_m = perturbed(machine, setting.geometry_std_m, geometry)
    q = q_m.copy()
    q[:, 3:] += zeros_m
    positions = reflector_positions(reflectors.points_m, forward_kinematics(real, q, commanded))
    return with_outliers(positions + noise.normal(0.0, reflectors.noise_m, positions.shape), setting.outliers, noise)[0]


def with_outliers(positions_m: FloatArray, part: float, random: np.random.Generator) -> tuple[FloatArray, BoolArray]:
    """Put a part of points (n, k, 3) 50 mm away, in any direction; tell which, (n, k). None: nothing is drawn."""
    if part == 0.0:
        return positions_m, np.zeros(positions_m.shape[:2], dtype=bool)
    away = random.normal(size=positions_m.shape)
    away *= _OUTLIER_M / np.linalg.norm(away, axis=2, keepdims=True)
    is_outlier = random.random(positions_m.shape[:2]) < part
    return positions_m + np.where(is_outlier[..., None], away, 0.0), is_outlier
