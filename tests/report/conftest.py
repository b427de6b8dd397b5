"""Results of a short run, as the report is given them, and the page that becomes of them."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pipeline.artifacts import jsonable
from pipeline.certify.recheck import KappaProfile
from pipeline.config import Config
from pipeline.config.file import parse_config
from pipeline.machine import Machine
from pipeline.machine.geometry import ACTUATORS
from pipeline.refine.measure import measure_path, sample_path
from pipeline.report import Report, RunResults, StageFacts, build_report, render_page
from pipeline.report.coarse import CoarseMotion, drive_coarse
from pipeline.report.tables import workspace_part
from pipeline.retime import measure_drives, measure_quality, measure_trajectory, sample_trajectory
from pipeline.route.metric import step_sizes
from pipeline.stage import Stage
from pipeline.summary.certificate import certificate_section
from pipeline.summary.drives import drives_part
from pipeline.summary.path import path_section
from pipeline.summary.regions import regions_section
from pipeline.summary.route import route_section
from pipeline.summary.trajectory import quality_part, trajectory_section
from pipeline.summary.versions import versions
from tests.report.browser import browsing
from tests.report.opened import DESKTOP, Opened
from tests.run.short_results import make_certificate, make_refinement, make_regions, make_route, make_trajectory


@pytest.fixture(scope="session")
def config(quick_config: Config) -> Config:
    """Take the coarse grid, few check points, and a time law that needs no solver."""
    data = quick_config.model_dump(mode="json")
    data["refine"]["check_points"] = 1_000
    data["retime"]["jerk"] = False
    return parse_config(data)


def facts_of(config: Config, sections: Mapping[Stage, dict[str, object]]) -> dict[Stage, StageFacts]:
    """Say of each stage that it was done and wrote one file."""
    return {
        stage: StageFacts(
            False, jsonable({**section, "seconds": 1.0}), {f"{stage}.npz": f"{stage}-hash"}, f"words of {stage}"
        )
        for stage, section in sections.items()
    }


@pytest.fixture(scope="session")
def complete(config: Config, machine: Machine) -> RunResults:
    """Give the results of a run that went to its end."""
    refinement = make_refinement(machine)
    s = np.linspace(0.0, 1.0, config.refine.check_points)
    coarse, refined = sample_path(refinement.coarse, s), sample_path(refinement.path, s)
    certificate = make_certificate(refinement.path)
    trajectory = make_trajectory(refinement.path)
    figures = measure_trajectory(trajectory, sample_trajectory(trajectory, config.retime.period_s))
    steps = step_sizes(config.route)
    sections = {
        Stage.REGIONS: regions_section(config, make_regions(machine)),
        Stage.ROUTE: route_section(make_route(machine)),
        Stage.REFINE: path_section(refinement, measure_path(refined, steps), measure_path(coarse, steps)),
        Stage.CERTIFY: certificate_section(certificate),
        Stage.RETIME: trajectory_section(figures)
        | quality_part(measure_quality(trajectory))
        | drives_part(measure_drives(trajectory), ACTUATORS),
    }
    return RunResults(
        config=config,
        machine=machine,
        facts=facts_of(config, sections),
        versions=versions(),
        route=make_route(machine),
        refinement=refinement,
        samples=(coarse, refined),
        bounds=certificate.bounds,
        profile=KappaProfile(np.array([0.0, 0.5, 1.0]), np.array([30.0, 31.0])),
        trajectory=trajectory,
        coarse=drive_coarse(config, refinement.coarse),
        workspace=workspace_part(machine),
    )


@pytest.fixture(scope="session")
def report(complete: RunResults) -> Report:
    """Give the report of the whole run."""
    return build_report(complete)


@pytest.fixture(scope="session")
def bodies_report(complete: RunResults, bodies_config: Config, bodies_machine: Machine) -> Report:
    """Give the report of a run whose machine has bodies, without a coarse motion and proof."""
    data = bodies_config.model_dump(mode="json")
    data["retime"]["jerk"] = False
    trajectory = make_trajectory(make_refinement(bodies_machine).path)
    run = replace(complete, config=parse_config(data), machine=bodies_machine, trajectory=trajectory)
    return build_report(replace(run, samples=None, bounds=None, profile=None, coarse=CoarseMotion("")))


@pytest.fixture(scope="session")
def page(report: Report) -> str:
    """Give the page of the whole run."""
    return render_page(report)


@pytest.fixture(scope="session")
def file(page: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write the page of the whole run."""
    path = tmp_path_factory.mktemp("report") / "report.html"
    path.write_text(page, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Start the browser for one file of tests: no two may run in one process."""
    with browsing() as started:
        yield started


@pytest.fixture(scope="module")
def desk(browser: Any, file: Path) -> Iterator[Opened]:
    """Open the page of the whole run on a desktop."""
    opened = Opened(browser, file, DESKTOP)
    yield opened
    opened.page.close()


@pytest.fixture(scope="session")
def failed_at() -> Callable[[RunResults, Stage], RunResults]:
    """Give tests a run that failed at a stage, and so has nothing of it or of what follows."""

    def fail(run: RunResults, stage: Stage) -> RunResults:
        section = {"status": "failed", "reason": "the <reason> & more", "advice": "change <this>"}
        before = {name: facts for name, facts in run.facts.items() if name in stage.earlier}
        nothing = replace(run, route=None, refinement=None, samples=None, bounds=None, profile=None, trajectory=None)
        if stage in Stage.ROUTE.later:
            nothing = replace(nothing, route=run.route)
        if stage in (Stage.CERTIFY, Stage.RETIME):
            nothing = replace(nothing, refinement=run.refinement, samples=run.samples)
        if stage is Stage.RETIME:
            nothing = replace(nothing, bounds=run.bounds, profile=run.profile)
        return replace(nothing, facts={**before, stage: StageFacts(True, section)})

    return fail
