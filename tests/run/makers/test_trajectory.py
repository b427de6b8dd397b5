"""The files of the trajectory stage."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from pipeline.artifacts.layout import BACK_CSV, TRAJECTORY_CSV
from pipeline.config import Config
from pipeline.export import read_trajectory_csv
from pipeline.machine import Machine
from pipeline.machine.actuator_space.controller_units import controller_units
from pipeline.retime import sample_trajectory, way_back
from pipeline.run.makers.trajectory import trajectory_product
from pipeline.run.results import Results
from tests.run.short_results import make_refinement, make_trajectory


def test_tables_are_in_the_units_of_the_controller(
    fast_config: Config, machine: Machine, vary: Callable, tmp_path: Path
) -> None:
    """Both ways come back as they were planned by what the configuration says of zeros and scales."""
    given = {"c1": {"zero_m": 5e-4}, "l3b": {"zero_m": -3e-4, "scale": 0.9997}}
    config = vary(fast_config, {"machine.actuators": given})
    units, results = controller_units(config.machine), Results(config, machine, tmp_path)
    trajectory = make_trajectory(make_refinement(machine).path)
    back = way_back(config, trajectory)
    files = trajectory_product(results, trajectory, back).files
    for name, motion in ((TRAJECTORY_CSV, trajectory), (BACK_CSV, back)):
        samples, table = sample_trajectory(motion, config.retime.period_s), read_trajectory_csv(files[name].decode())
        np.testing.assert_allclose(units.to_geometry(table.q_m), samples.q_m, rtol=0.0, atol=1e-11)
        assert np.abs(table.q_m - samples.q_m).max() > 2e-4
