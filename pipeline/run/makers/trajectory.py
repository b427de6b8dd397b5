"""Make the trajectory, and that of the way back."""

from typing import TYPE_CHECKING

from pipeline.artifacts.results.trajectory import back_files, trajectory_files
from pipeline.errors import NoSolutionError
from pipeline.export import sidecar
from pipeline.machine.actuator_space.controller_units import controller_units
from pipeline.machine.geometry import ACTUATORS
from pipeline.progress import Monitor
from pipeline.retime import (
    measure_drives,
    measure_quality,
    measure_trajectory,
    prove_motion,
    retime_path,
    sample_trajectory,
    way_back,
    whole_periods,
)
from pipeline.retime.result import Trajectory
from pipeline.run.product import Product
from pipeline.stage import Stage
from pipeline.summary.drives import drives_part
from pipeline.summary.section import failure_section, without_part
from pipeline.summary.trajectory import back_section, proven_part, quality_part, trajectory_section

if TYPE_CHECKING:
    from pipeline.run.results import Results


def make_trajectory(results: "Results", monitor: Monitor) -> Product:
    """Time the path and its way back, and sample both for the controller.

    If only the way back has no solution, the way there is still a result, and the summary says so.
    """
    config = results.config
    trajectory = retime_path(config, results.refinement.path, monitor)
    monitor.progress("timing the way back")
    try:
        back: Trajectory | NoSolutionError = way_back(config, trajectory, monitor)
    except NoSolutionError as error:
        back = error
    monitor.progress("sampling both ways")
    return trajectory_product(results, trajectory, back)


def trajectory_product(results: "Results", trajectory: Trajectory, back: Trajectory | NoSolutionError) -> Product:
    """Keep a trajectory, and make the files and the summary of it and of its way back, or say why there is none."""
    results.keep(Stage.RETIME, trajectory)
    config, machine = results.config, results.machine
    units = controller_units(config.machine)
    samples = sample_trajectory(trajectory, config.retime.period_s)
    figures = measure_trajectory(trajectory, samples)
    files = trajectory_files(
        trajectory, samples.for_controller(units), sidecar(config, machine, samples, figures.usage)
    )
    section = trajectory_section(figures) | quality_part(measure_quality(trajectory, config.retime.speed))
    section |= drives_part(measure_drives(whole_periods(trajectory, config.retime.period_s)), ACTUATORS)
    section |= proven_part(prove_motion(trajectory, jerk=config.retime.jerk))
    if isinstance(back, NoSolutionError):
        return Product(files, {**section, **without_part("back", failure_section(back.reason, back.advice))})
    samples = sample_trajectory(back, config.retime.period_s)
    figures = measure_trajectory(back, samples)
    files |= back_files(machine, samples.for_controller(units), sidecar(config, machine, samples, figures.usage))
    return Product(
        files, {**section, "back": back_section(figures) | proven_part(prove_motion(back, jerk=config.retime.jerk))}
    )
