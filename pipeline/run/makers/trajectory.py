"""Make the trajectory, and that of the way back."""

from dataclasses import replace
from typing import TYPE_CHECKING

from pipeline.artifacts.results.trajectory import back_files, trajectory_files
from pipeline.errors import NoSolutionError
from pipeline.export import sidecar
from pipeline.machine.actuator_space.controller_units import controller_units
from pipeline.machine.geometry import ACTUATORS
from pipeline.progress import Monitor
from pipeline.retime import (
    interpolations,
    measure_drives,
    measure_quality,
    measure_trajectory,
    prove_motion,
    require_proven,
    retime_path,
    sample_trajectory,
    way_back,
    whole_periods,
)
from pipeline.retime.result import Trajectory
from pipeline.run.makers.following import table_of_motion
from pipeline.run.product import Product
from pipeline.stage import Stage
from pipeline.summary.drives import drives_part
from pipeline.summary.section import failure_section, without_part
from pipeline.summary.trajectory import (
    INTERPOLATION,
    back_section,
    interpolation_section,
    proven_part,
    quality_part,
    trajectory_section,
)

if TYPE_CHECKING:
    from pipeline.run.results import Results


def make_trajectory(results: "Results", monitor: Monitor) -> Product:
    """Time the path and its way back, and sample both for the controller.

    If only the way back has no solution, the way there is still a result, and the summary says so.
    """
    config, jerk = results.config, results.config.retime.jerk
    trajectory = retime_path(config, results.refinement.path, monitor)
    monitor.progress("bounding forces in motion")
    require_proven(trajectory, jerk=jerk, loads=True)
    monitor.progress("timing the way back")
    try:
        driven_back = way_back(config, trajectory, monitor)
        require_proven(driven_back, backwards=True, jerk=jerk, loads=True)
        back: Trajectory | NoSolutionError = driven_back
    except NoSolutionError as error:
        back = error
    monitor.progress("sampling both ways")
    product = trajectory_product(results, trajectory, back)
    return replace(product, completed=table_of_motion(results, trajectory))


def trajectory_product(results: "Results", trajectory: Trajectory, back: Trajectory | NoSolutionError) -> Product:
    """Keep a trajectory, and make the files and the summary of it and of its way back, or say why there is none."""
    results.keep(Stage.RETIME, trajectory)
    config, machine = results.config, results.machine
    units = controller_units(config.machine)
    samples = sample_trajectory(trajectory, config.retime.period_s)
    figures = measure_trajectory(trajectory, samples)
    rows = interpolations(whole_periods(trajectory, config.retime.period_s), samples, jerk=config.retime.jerk)
    described = sidecar(config, machine, samples, figures.usage, interpolated=rows)
    files = trajectory_files(trajectory, samples.for_controller(units), described)
    section = trajectory_section(figures) | quality_part(measure_quality(trajectory, config.retime.speed))
    section |= drives_part(measure_drives(whole_periods(trajectory, config.retime.period_s)), ACTUATORS)
    section |= {INTERPOLATION: interpolation_section(rows)}
    section |= proven_part(prove_motion(trajectory, jerk=config.retime.jerk, loads=True))
    if isinstance(back, NoSolutionError):
        return Product(files, {**section, **without_part("back", failure_section(back.reason, back.advice))})
    samples = sample_trajectory(back, config.retime.period_s)
    figures = measure_trajectory(back, samples)
    rows = interpolations(whole_periods(back, config.retime.period_s), samples, jerk=config.retime.jerk)
    described = sidecar(config, machine, samples, figures.usage, interpolated=rows)
    files |= back_files(machine, samples.for_controller(units), described)
    proven = proven_part(prove_motion(back, jerk=config.retime.jerk, loads=True))
    return Product(
        files, {**section, "back": back_section(figures) | {INTERPOLATION: interpolation_section(rows)} | proven}
    )
