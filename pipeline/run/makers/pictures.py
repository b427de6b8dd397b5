"""The figures as files, in two parts: those of stages one and two, and those that need proof or trajectory."""

from typing import TYPE_CHECKING

from pipeline.artifacts.results.figures import figure_files
from pipeline.figures import FIGURES, RunData, all_figures
from pipeline.retime import sample_trajectory
from pipeline.run.makers.path_samples import sample_paths
from pipeline.run.makers.proven_profile import proven_profile

if TYPE_CHECKING:
    from pipeline.run.results import Results

_LATE = {"kappa_profile", "trajectory", "trajectory_samples"}
"""Fields of `RunData` that are not known before proof and trajectory are."""


def early_pictures(results: "Results") -> dict[str, bytes]:
    """Draw what needs no more than regions, route and path."""
    coarse, refined = results.derive(sample_paths)
    data = RunData(
        results.config, results.machine, results.route, regions=results.regions, coarse=coarse, refined=refined
    )
    return figure_files(all_figures(data), results.config.figures.pdf)


def late_pictures(results: "Results") -> dict[str, bytes]:
    """Draw the rest."""
    coarse, refined = results.derive(sample_paths)
    data = RunData(
        results.config,
        results.machine,
        results.route,
        coarse=coarse,
        refined=refined,
        kappa_profile=results.derive(proven_profile),
        trajectory=results.trajectory,
        trajectory_samples=sample_trajectory(results.trajectory, results.config.retime.period_s),
    )
    rows = tuple(row for row in FIGURES if not _LATE.isdisjoint(row.needs))
    return figure_files(all_figures(data, rows), results.config.figures.pdf)
