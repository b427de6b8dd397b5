"""The simulated twin of a run of a study: its figures, beside those of the run."""

from pathlib import Path

from pipeline.artifacts import json_bytes, write_whole
from pipeline.errors import NoSolutionError
from pipeline.run import open_results
from pipeline.simulate import Deviations, build_drives, build_plant, controller_period, plan_motion, simulate_motion
from pipeline.simulate.table import simulation_data
from pipeline.stage import Stage
from pipeline.study.config import TwinConfig


def simulate_run(folder: Path, twin: TwinConfig, file: Path) -> None:
    """Simulate the motion of a run, and write what came of it as `simulate` into a JSON file.

    Raises
    ------
    NoSolutionError
        When the twin does not stand at the goal in the end; the figures are written all the same.
    """
    results = open_results(folder, Stage.RETIME)
    deviations = Deviations(twin.geometry_m, twin.seed, twin.mass_error_percent / 100.0, twin.load_kg)
    plant = build_plant(results.machine, deviations)
    motion = plan_motion(results.trajectory, controller_period(results.config.retime.period_s))
    drives = build_drives(results.config.drives, results.machine)
    simulation = simulate_motion(results.machine, plant, drives, motion)
    write_whole(file, json_bytes({"simulate": simulation_data(simulation)}))
    verdict = simulation.verdict
    if not verdict.arrived:
        raise NoSolutionError(
            "simulate",
            f"{verdict.when} {verdict.reason}",
            "Drive slower, allow more force, or take other gains (gantry-tau tune RUN).",
        )
