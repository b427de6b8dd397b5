"""What each stage of a run does: call the stage, measure what it made, and say which files it becomes.

The stages' packages are imported when a stage runs: solvers and plotting take longer to load than a help text
should take to appear.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.machine.geometry import Machine
from pipeline.progress import Monitor, Progress
from pipeline.run.fingerprint import grid_fingerprint, with_proof
from pipeline.stage import Stage
from pipeline.summary.sections import Section

if TYPE_CHECKING:
    from pipeline.certify.recheck import KappaProfile, Statement
    from pipeline.refine.measure import PathSamples
    from pipeline.refine.result import Refinement
    from pipeline.retime.result import Trajectory
    from pipeline.route.regions.build import RegionTable
    from pipeline.route.result import Route


@dataclass
class Results:
    """The results of a run: those it made, and those of earlier runs, loaded when first asked for.

    `anew` says that what other runs computed is not to be used either, `tolerances` that the proof is to search
    calibration tolerances although the configuration does not ask for them.
    """

    config: Config
    machine: Machine
    folder: Path
    anew: bool = False
    tolerances: bool = False

    @property
    def asked(self) -> Config:
        """The configuration, asking for the proof that is wanted."""
        return with_proof(self.config, "tolerances") if self.tolerances else self.config

    @cached_property
    def regions(self) -> "RegionTable":
        """The region table."""
        from pipeline.artifacts.results import load_regions

        return load_regions(self.folder)

    @cached_property
    def route(self) -> "Route":
        """The route."""
        from pipeline.artifacts.results import load_route

        return load_route(self.folder)

    @cached_property
    def refinement(self) -> "Refinement":
        """The refined path and the coarse one."""
        from pipeline.artifacts.results import load_refinement

        return load_refinement(self.folder, self.machine)

    @cached_property
    def certificate(self) -> "Statement":
        """What the certificate's file claims."""
        from pipeline.artifacts.results import load_certificate

        return load_certificate(self.folder)

    @cached_property
    def profile(self) -> "KappaProfile | None":
        """What the certificate proves of kappa, box by box; None where no proof was wanted."""
        if self.config.certify.what == "nothing":
            return None
        from pipeline.certify.recheck import kappa_profile

        return kappa_profile(self.machine, self.refinement.path, self.certificate.chains[0])

    @cached_property
    def trajectory(self) -> "Trajectory":
        """The path in time."""
        from pipeline.artifacts.results import load_trajectory

        return load_trajectory(self.folder, self.refinement.path)

    @cached_property
    def samples(self) -> "tuple[PathSamples, PathSamples]":
        """Both paths, coarse and refined, sampled densely and in the same way."""
        from pipeline.refine.measure import sample_path

        s = np.linspace(0.0, 1.0, self.config.refine.check_points)
        return sample_path(self.refinement.coarse, s), sample_path(self.refinement.path, s)


@dataclass(frozen=True)
class Product:
    """What a stage made: its files by name, and its part of the summary."""

    files: dict[str, bytes]
    section: Section = field(default_factory=dict)


def make_regions(results: Results, progress: Progress, verbose: bool) -> Product:
    """Find every admissible region of the grid, and add what the task asks for."""
    from pipeline.artifacts.results import regions_files
    from pipeline.route import build_regions
    from pipeline.summary.sections import regions_section

    results.regions = build_regions(results.config, results.machine, progress, _grid(results, progress))
    return Product(regions_files(results.regions), regions_section(results.config, results.regions))


def _grid(results: Results, progress: Progress) -> "RegionTable":
    """Take the regions of grid and gates from an earlier run in the same place, or compute and keep them."""
    from pipeline.artifacts.region_cache import keep_grid, load_grid
    from pipeline.route import grid_regions

    runs, key = results.folder.parent, grid_fingerprint(results.config)
    kept = None if results.anew else load_grid(runs, key)
    if kept is not None:
        progress("regions: grid and gates known from an earlier run", 1.0)
        return kept
    grid = grid_regions(results.config, results.machine, progress)
    keep_grid(runs, key, grid)
    return grid


def make_route(results: Results, progress: Progress, verbose: bool) -> Product:
    """Search for the best route through the regions."""
    from pipeline.artifacts.results import route_files
    from pipeline.route import plan_route
    from pipeline.summary.sections import route_section

    results.route = plan_route(results.config, results.machine, results.regions, progress, verbose)
    return Product(route_files(results.route), route_section(results.route))


def make_path(results: Results, progress: Progress, verbose: bool) -> Product:
    """Smooth the route, and measure what came out against the route joined by straight lines."""
    from pipeline.artifacts.results import path_files
    from pipeline.refine import refine_path
    from pipeline.refine.measure import measure_path
    from pipeline.route.metric import step_sizes
    from pipeline.summary.sections import path_section

    results.refinement = refine_path(results.config, results.machine, results.route, Monitor(progress, verbose))
    progress(f"measuring both paths at {results.config.refine.check_points:,} points")
    coarse, refined = results.samples
    steps = step_sizes(results.config.route)
    section = path_section(results.refinement, measure_path(refined, steps), measure_path(coarse, steps))
    return Product(path_files(results.refinement, refined), section)


def make_certificate(results: Results, progress: Progress, verbose: bool) -> Product:
    """Prove that the path is one motion free of singularities and within its limits."""
    from pipeline.artifacts.results import certificate_files
    from pipeline.certify import certify_path
    from pipeline.summary.sections import certificate_facts, certificate_section, skipped_certificate

    config = results.asked
    if config.certify.what == "nothing":
        return Product({}, skipped_certificate())
    began = time.perf_counter()
    certificate = certify_path(config, results.machine, results.refinement.path, progress)
    facts = certificate_facts(config, time.perf_counter() - began)
    return Product(certificate_files(certificate, facts), certificate_section(certificate))


def make_trajectory(results: Results, progress: Progress, verbose: bool) -> Product:
    """Time the path and its way back, and sample both for the controller.

    Where the way back alone has no solution the way there is a result all the same, and the summary says so.
    """
    from pipeline.artifacts.results import trajectory_files
    from pipeline.export import sidecar
    from pipeline.retime import measure_trajectory, retime_path, sample_trajectory
    from pipeline.summary.sections import trajectory_section

    config, machine = results.config, results.machine
    trajectory = results.trajectory = retime_path(config, results.refinement.path, progress, verbose)
    progress("sampling the trajectory")
    samples = sample_trajectory(trajectory, config.retime.period_s)
    figures = measure_trajectory(trajectory, samples)
    files = trajectory_files(trajectory, samples, sidecar(config, machine, samples, figures.usage))
    back = _way_back(results, progress, verbose)
    return Product({**files, **back.files}, {**trajectory_section(figures), "back": back.section})


def _way_back(results: Results, progress: Progress, verbose: bool) -> Product:
    """Time and sample the way back; why there is none, where that is so."""
    from pipeline.artifacts.results import back_files
    from pipeline.export import sidecar
    from pipeline.retime import measure_trajectory, sample_trajectory, way_back
    from pipeline.summary.sections import back_section, failure_section

    config, machine = results.config, results.machine
    progress("timing the way back")
    try:
        back = way_back(config, results.trajectory, progress, verbose)
    except NoSolutionError as error:
        return Product({}, failure_section(error.reason, error.advice))
    samples = sample_trajectory(back, config.retime.period_s)
    figures = measure_trajectory(back, samples)
    return Product(
        back_files(machine, samples, sidecar(config, machine, samples, figures.usage)), back_section(figures)
    )


def make_figures(results: Results, progress: Progress, verbose: bool) -> Product:
    """Draw the results, and put all that people look at into one page."""
    from pipeline.artifacts import read_state
    from pipeline.artifacts.layout import REPORT
    from pipeline.artifacts.results import figure_files
    from pipeline.artifacts.state import State
    from pipeline.figures import all_figures
    from pipeline.retime import sample_trajectory
    from pipeline.run.reporting import report_page

    progress("drawing")
    coarse, refined = results.samples
    samples = sample_trajectory(results.trajectory, results.config.retime.period_s)
    figures = all_figures(
        results.config,
        results.machine,
        results.route,
        coarse,
        refined,
        samples,
        results.trajectory,
        results.regions,
        results.profile,
    )
    files = figure_files(figures)
    progress("writing the report")
    page = report_page(results, read_state(results.folder) or State())
    return Product({**files, REPORT: page}, {"status": "done", "count": len(figures)})


MAKE: dict[Stage, Callable[[Results, Progress, bool], Product]] = {
    Stage.REGIONS: make_regions,
    Stage.ROUTE: make_route,
    Stage.REFINE: make_path,
    Stage.CERTIFY: make_certificate,
    Stage.RETIME: make_trajectory,
    Stage.FIGURES: make_figures,
}
"""What makes the result of each stage; `verbose` lets solvers talk."""
