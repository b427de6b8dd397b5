"""Make the report of what there is of a run."""

from typing import TYPE_CHECKING

from pipeline.artifacts.layout import failure_picture
from pipeline.artifacts.results.pose_error import load_pose_error
from pipeline.artifacts.state import Record, State
from pipeline.config.choices import Proof
from pipeline.report import RunResults, StageFacts, build_report, render_page
from pipeline.run.makers.path_samples import sample_paths
from pipeline.run.makers.pictures import sampled_error
from pipeline.run.makers.proven_profile import proven_profile
from pipeline.run.makers.report_parts import coarse_motion, workspace
from pipeline.run.stage_specs import Specs, spec_of
from pipeline.stage import Stage
from pipeline.summary.versions import versions

if TYPE_CHECKING:
    from pipeline.pose_error import PoseError, SampledError
    from pipeline.run.results import Results


def report_page(results: "Results", state: State) -> bytes:
    """Make the page from the results of the stages that are done according to the state."""
    done = {stage for stage, record in state.stages.items() if record.status == "done"}
    proven = Stage.CERTIFY in done and results.config.certify.what != Proof.NOTHING
    run = RunResults(
        config=results.config,
        machine=results.machine,
        facts={
            stage: _facts(results.specs, stage, record)
            for stage, record in state.stages.items()
            if stage is not Stage.FIGURES
        },
        versions=versions(),
        route=results.route if Stage.ROUTE in done else None,
        refinement=results.refinement if Stage.REFINE in done else None,
        samples=results.derive(sample_paths) if Stage.REFINE in done else None,
        bounds=results.certificate.bounds if proven else None,
        profile=results.derive(proven_profile) if proven else None,
        trajectory=results.trajectory if Stage.RETIME in done else None,
        coarse=results.derive(coarse_motion) if {Stage.ROUTE, Stage.REFINE, Stage.RETIME} <= done else None,
        workspace=results.derive(workspace),
        pose_error=_pose_error(results) if proven else None,
        reach=_reach(results, state),
    )
    return render_page(build_report(run)).encode()


def _pose_error(results: "Results") -> "tuple[PoseError, SampledError] | None":
    """Load the proven error of the tool, and sample it; None if it was not asked for."""
    found, sampled = results.derive(load_pose_error), results.derive(sampled_error)
    return None if found is None or sampled is None else (found, sampled)


def _reach(results: "Results", state: State) -> bytes | None:
    """Read the picture that comes with the reasons why there is no route."""
    picture = results.folder / failure_picture(Stage.ROUTE)
    failed = Stage.ROUTE in state.stages and state.stages[Stage.ROUTE].status == "failed"
    return picture.read_bytes() if failed and picture.is_file() else None


def _facts(specs: Specs, stage: Stage, record: Record) -> StageFacts:
    failed = record.status == "failed"
    words = "" if failed else spec_of(specs, stage).words(record.summary)
    return StageFacts(failed, record.summary, record.files, words)
