"""Stages that take no time: real files and summaries, but of results that are made up."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from pipeline.artifacts.results.figures import figure_files
from pipeline.certify import path_sha256
from pipeline.config import Config
from pipeline.config.choices import Proof
from pipeline.config.file import config_sha256
from pipeline.errors import NoSolutionError
from pipeline.progress import Monitor
from pipeline.refine.result import Path as RefinedPath
from pipeline.retime import Trajectory, way_back
from pipeline.run import Reporter, Results, RunOptions, RunReport, run_pipeline
from pipeline.run.makers.certificate import certificate_product, no_certificate
from pipeline.run.makers.figures import figures_product
from pipeline.run.makers.grid_cache import cached_grid
from pipeline.run.makers.path import path_product
from pipeline.run.makers.regions import regions_product
from pipeline.run.makers.route import route_product
from pipeline.run.makers.trajectory import trajectory_product
from pipeline.run.product import Product
from pipeline.run.stage_specs import SPECS, Specs
from pipeline.stage import Stage
from pipeline.status import Status
from tests.run.short_results import (
    make_certificate,
    make_refinement,
    make_regions,
    make_route,
    make_trajectory,
    with_tube,
)

Messages = list[tuple[str, float | None]]
_MOTIONS: dict[tuple[str, str, str], tuple[Trajectory, Trajectory]] = {}


def _motions(config: Config, path: RefinedPath) -> tuple[Trajectory, Trajectory]:
    """Make the motion along a path and the way back; the dynamics of the same path are tabulated once for all runs."""
    key = path_sha256(path), config_sha256(config.machine), config_sha256(config.retime)
    if key not in _MOTIONS:
        trajectory = make_trajectory(path)
        _MOTIONS[key] = trajectory, way_back(config, trajectory)
    return _MOTIONS[key]


@dataclass
class FakeStages:
    """What the fake stages were asked for, and how they are to behave."""

    calls: list[str] = field(default_factory=list)
    verbose: list[bool] = field(default_factory=list)
    failures: dict[str, BaseException] = field(default_factory=dict)
    messages: dict[str, Messages] = field(default_factory=dict)
    objective: float = 100.0
    route_status: Status = Status.OPTIMAL
    routes: int | None = None
    caches: bool = False
    grids: int = 0
    proofs: list[str] = field(default_factory=list)
    no_way_back: NoSolutionError | None = None

    @property
    def specs(self) -> Specs:
        """The rows of the stages, with fake makers in place of the real ones."""
        makers: dict[Stage, Callable[[Results, Monitor], Product]] = {
            Stage.REGIONS: self._regions,
            Stage.ROUTE: self._route,
            Stage.REFINE: self._path,
            Stage.CERTIFY: self._certificate,
            Stage.RETIME: self._trajectory,
            Stage.FIGURES: self._figures,
        }
        rows = (replace(spec, make=makers[spec.stage]) for spec in SPECS)
        return tuple(row if row.report is None else replace(row, report=self._page) for row in rows)

    def run(self, config: Config, folder: Path, reporter: Reporter | None = None, **options: Any) -> RunReport:
        """Run them into a folder."""
        return run_pipeline(config, folder, RunOptions(**options), reporter, self.specs)

    def with_row(self, stage: Stage, **changes: Any) -> Specs:
        """Change the row of a stage."""
        return tuple(replace(row, **changes) if row.stage is stage else row for row in self.specs)

    def taken(self) -> list[str]:
        """Give the calls since the last time."""
        calls, self.calls = self.calls, []
        return calls

    def _enter(self, name: str, monitor: Monitor) -> None:
        """Count a call, report progress, and fail if that is asked for."""
        self.calls.append(name)
        for message, fraction in self.messages.get(name, [("working", None), ("still working", 0.5)]):
            monitor.progress(message, fraction)
        if name in self.failures:
            raise self.failures[name]

    def _regions(self, results: Results, monitor: Monitor) -> Product:
        def grid() -> Any:
            self.grids += 1
            return make_regions(results.machine, 3)

        assert len(cached_grid(results, monitor, grid) if self.caches else grid()) == 3
        self._enter("regions", monitor)
        return regions_product(results, make_regions(results.machine))

    def _route(self, results: Results, monitor: Monitor) -> Product:
        assert len(results.regions) == 5
        self.verbose.append(monitor.verbose)
        self._enter("route", monitor)
        if self.routes is None:
            return route_product(results, make_route(results.machine, self.objective, self.route_status))
        rank = results.config.route.alternative
        if rank > self.routes:
            raise NoSolutionError("route", f"there are {self.routes} routes", "ask for fewer")
        return route_product(results, make_route(results.machine, self.objective + rank, self.route_status))

    def _path(self, results: Results, monitor: Monitor) -> Product:
        assert len(results.route) == 4
        self.verbose.append(monitor.verbose)
        self._enter("refine", monitor)
        return path_product(results, make_refinement(results.machine))

    def _certificate(self, results: Results, monitor: Monitor) -> Product:
        what = results.config_to_prove.certify.what
        if what == Proof.NOTHING:
            return no_certificate()
        path = results.refinement.path
        self._enter("certify", monitor)
        self.proofs.append(what)
        return certificate_product(results.config_to_prove, make_certificate(path), 0.0)

    def _trajectory(self, results: Results, monitor: Monitor) -> Product:
        path = results.refinement.path
        self._enter("retime", monitor)
        trajectory, back = _motions(results.config, path)
        return trajectory_product(results, trajectory, self.no_way_back or back)

    def _figures(self, results: Results, monitor: Monitor) -> Product:
        assert results.trajectory.duration_s == 2.0
        self._enter("figures", monitor)
        pictures = figure_files({"route": Figure((1, 1)), "kappa": Figure((1, 1))}, results.config.figures.pdf)
        return figures_product(pictures, b"<!doctype html>")

    def _page(self, *_: object) -> bytes:
        return b"<!doctype html>"


def proven(stages: FakeStages, error_m: float) -> Specs:
    """Give stages whose certificate has a chain of actuators that are off by `error_m` alike."""

    def make(results: Results, monitor: Monitor) -> Product:
        certificate = with_tube(make_certificate(results.refinement.path), error_m)
        return certificate_product(results.config_to_prove, certificate, 0.0)

    return stages.with_row(Stage.CERTIFY, make=make)
