"""From the results of a run to the content of its report: no files, no clocks, no HTML."""

from collections.abc import Mapping
from dataclasses import dataclass

from pipeline.certify.bounds import Bounds
from pipeline.certify.recheck import KappaProfile
from pipeline.compare.criteria import MeasuredPath
from pipeline.compare.metrics import compare_paths
from pipeline.compare.motion import common_retiming, measure_motion, retimed
from pipeline.config import Config
from pipeline.config.file import config_sha256, dump_config
from pipeline.machine.geometry import Machine
from pipeline.pose_error import PoseError, SampledError
from pipeline.refine.measure import PathSamples, measure_path
from pipeline.refine.result import Refinement
from pipeline.report.coarse import CoarseMotion, Retime, drive_coarse
from pipeline.report.data import Motion, Picture, Proof, Report, RoutePart, Table
from pipeline.report.motion import build_motion, build_scene
from pipeline.report.pictures import pairs_picture, pose_error_picture, reach_picture, route_part
from pipeline.report.tables import (
    bounds_table,
    build_proof,
    comparison_table,
    distances_table,
    drives_table,
    quality_table,
    rows_table,
    workspace_part,
)
from pipeline.report.verdicts import Facts, StageFacts, headline, stage_rows, used_limits, verdicts
from pipeline.retime.result import Trajectory
from pipeline.route.metric import step_sizes
from pipeline.route.result import Route
from pipeline.stage import Stage
from pipeline.summary.section import DRIVES, QUALITY
from pipeline.summary.trajectory import INTERPOLATION


@dataclass(frozen=True, eq=False)
class RunResults:
    """What a run has made so far; None for stages that failed or have not been run.

    Attributes
    ----------
    facts : mapping
        How each stage that was run ended.
    versions : mapping
        Versions of everything that affects the results.
    route
        The route.
    refinement, samples
        Both paths, and dense samples of the coarse and the refined one.
    bounds, profile
        What the certificate proves, and its bound of kappa over each box.
    trajectory
        The refined path in time.
    coarse, workspace
        The coarse path in motion, and the table and picture of the workspace, where they were made beforehand.
    pose_error
        The proven error of the tool, and the same at samples, where it was asked for.
    reach
        A picture, PNG, of what can be reached where there is no route.
    """

    config: Config
    machine: Machine
    facts: Facts
    versions: Mapping[str, str]
    route: Route | None = None
    refinement: Refinement | None = None
    samples: tuple[PathSamples, PathSamples] | None = None
    bounds: Bounds | None = None
    profile: KappaProfile | None = None
    trajectory: Trajectory | None = None
    coarse: CoarseMotion | None = None
    workspace: tuple[Table, Picture] | None = None
    pose_error: tuple[PoseError, SampledError] | None = None
    reach: bytes | None = None


def build_report(run: RunResults, retime: Retime = retimed) -> Report:
    """Collect everything, and time the coarse path like the refined one, so that both can be shown in motion.

    Parameters
    ----------
    retime : function
        Times a path with given settings, as `retimed` does.

    Raises
    ------
    ForwardKinematicsError
        Where a pose along a path cannot be found.
    """
    config, machine = run.config, run.machine
    coarse = _coarse(run, retime)
    workspace, picture = run.workspace or workspace_part(machine)
    timing = run.facts.get(Stage.RETIME)
    return Report(
        name=config.name,
        task=f"{config.task.start.mode} → {config.task.goal.mode}",
        headline=headline(run.facts),
        verdicts=verdicts(run.facts),
        stages=stage_rows(run.facts),
        usage=() if timing is None or timing.failed else used_limits(timing.section),
        config_yaml=dump_config(config),
        provenance=_provenance(run),
        scene=build_scene(config, machine),
        quality=_quality(run.facts),
        rows=_rows(timing),
        drives=_drives(timing),
        comparison=_comparison(run, coarse, retime),
        workspace=workspace,
        workspace_picture=picture,
        route=_route(run),
        reach=_reach(run),
        bounds=None if run.bounds is None else bounds_table(config, machine, run.bounds),
        distances=None if run.bounds is None else distances_table(config, machine, run.bounds),
        proof=_proof(run),
        pose_error=None if run.pose_error is None else pose_error_picture(*run.pose_error),
        pairs=None if run.samples is None else pairs_picture(config, machine, run.samples[1]),
        motions=_motions(run, coarse),
        motion_note=_why_still(run.facts) if run.trajectory is None else coarse.note,
    )


def _route(run: RunResults) -> RoutePart | None:
    """Show the route; a picture only where there is no motion, which shows more."""
    if run.route is None:
        return None
    return route_part(run.config, run.machine, run.route, run.samples, drawn=run.trajectory is None)


def _reach(run: RunResults) -> Picture | None:
    if run.reach is None:
        return None
    return reach_picture(run.reach, run.facts[Stage.ROUTE].section.get("why_not", ()))


def _coarse(run: RunResults, retime: Retime) -> CoarseMotion:
    if run.refinement is None or run.trajectory is None:
        return CoarseMotion("")
    return run.coarse or drive_coarse(run.config, run.refinement.coarse, retime)


def _motions(run: RunResults, coarse: CoarseMotion) -> tuple[Motion, ...]:
    if run.trajectory is None:
        return ()
    refined = build_motion(run.config, run.trajectory, "refined")
    return (refined,) if coarse.motion is None else (refined, coarse.motion)


def _why_still(facts: Facts) -> str:
    for stage in (Stage.REGIONS, Stage.ROUTE, Stage.REFINE, Stage.CERTIFY, Stage.RETIME):
        if stage not in facts or facts[stage].failed:
            what = "failed" if stage in facts else "has not been run"
            return f"There is no motion to show: {stage} {what}."
    return "There is no motion to show."


def _comparison(run: RunResults, coarse: CoarseMotion, retime: Retime) -> Table | None:
    """Compare the paths, and their motions if there are both: at full speed, without waiting at the ends."""
    if run.samples is None:
        return None
    steps = step_sizes(run.config.route)
    refined = None
    if run.trajectory is not None and coarse.figures is not None:
        refined = measure_motion(_at_full_speed(run.config, run.trajectory, retime))
    before, after = (
        MeasuredPath(measure_path(samples, steps), motion)
        for samples, motion in zip(run.samples, (coarse.figures, refined), strict=True)
    )
    return comparison_table(compare_paths(before, after))


def _quality(facts: Facts) -> Table | None:
    """Tabulate the quality of the motion, once it is timed."""
    parts = [facts[stage].section.get(QUALITY) for stage in (Stage.REFINE, Stage.RETIME) if stage in facts]
    known = [part for part in parts if part is not None]
    return quality_table(*known) if len(known) == 2 else None


def _rows(timing: StageFacts | None) -> Table | None:
    """Tabulate what a controller makes of the rows, once the motion is timed."""
    section = None if timing is None else timing.section.get(INTERPOLATION)
    return None if section is None else rows_table(section)


def _drives(timing: StageFacts | None) -> Table | None:
    """Tabulate what the drives feel, once the motion is timed."""
    section = None if timing is None else timing.section.get(DRIVES)
    return None if section is None else drives_table(section)


def _at_full_speed(config: Config, trajectory: Trajectory, retime: Retime) -> Trajectory:
    common = common_retiming(config)
    return trajectory if common == config.retime else retime(config, common, trajectory.path)


def _proof(run: RunResults) -> Proof | None:
    if run.profile is None or run.samples is None:
        return None
    return build_proof(run.config, run.samples[1], run.profile)


def _provenance(run: RunResults) -> tuple[tuple[str, str], ...]:
    """List versions, the hash of the configuration, and the hashes of all files that stages have written."""
    files = [(name, digest) for facts in run.facts.values() if not facts.failed for name, digest in facts.files.items()]
    return (*run.versions.items(), ("configuration (SHA-256)", config_sha256(run.config)), *files)
