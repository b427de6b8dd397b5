"""Motions between stations: a run per proven route, that of the way back being the same run, backwards."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pipeline.artifacts.layout import ATLAS_RUNS
from pipeline.atlas.record import MotionRecord
from pipeline.config import Config
from pipeline.config.file import config_sha256
from pipeline.errors import ConfigError, NoSolutionError
from pipeline.progress import Monitor
from pipeline.run.execute import run_pipeline
from pipeline.run.options import RunOptions
from pipeline.run.reporter import NamedReporter, failure_of
from pipeline.run.stage_specs import Specs
from pipeline.run.up_to_date.fingerprint import fingerprint
from pipeline.stage import STAGES, Stage
from pipeline.summary.section import failed_part


@dataclass(frozen=True)
class Motions:
    """The motion there, and the same one backwards."""

    there: MotionRecord
    backwards: MotionRecord


class MotionMaker:
    """Runs the later stages for routes of an atlas, each pair once, in a run folder of its own.

    Parameters
    ----------
    folder : Path
        That of the atlas.
    last : Stage
        The stage to stop after.
    force : bool
        Stages run also where they are up to date.
    specs : tuple of StageSpec
        The stages.
    """

    def __init__(self, folder: Path, last: Stage, force: bool, specs: Specs, monitor: Monitor) -> None:
        self._folder = folder
        self._options = RunOptions(last=last, force=force, why_not=False, verbose=monitor.verbose)
        self._specs = specs
        self._monitor = monitor
        self._made: dict[str, Motions] = {}

    def motions(self, name: str, config: Config, given: Mapping[Stage, Callable[[], Any]]) -> Motions:
        """Make the motion of a pair, or look up what was made of it; `given` has its regions and its route."""
        if name not in self._made:
            made = self._make(name, config, given)
            self._made[name] = Motions(self._sealed(made.there, config), self._sealed(made.backwards, config))
        return self._made[name]

    def _sealed(self, motion: MotionRecord, config: Config) -> MotionRecord:
        return motion.model_copy(update={"fingerprint": motion_fingerprint(self._specs, config, motion.to)})

    def _make(self, name: str, config: Config, given: Mapping[Stage, Callable[[], Any]]) -> Motions:
        run = f"{ATLAS_RUNS}/{name}"
        reporter = NamedReporter(name, self._monitor.progress)
        try:
            report = run_pipeline(config, self._folder / run, self._options, reporter, self._specs, given)
        except (ConfigError, NoSolutionError) as error:
            stage, reason, advice = failure_of(error)
            failed = MotionRecord(status="failed", run=run, to=stage, reason=reason, advice=advice)
            return Motions(failed, failed.model_copy(update={"backwards": True}))
        made = _record(run, self._options.last, report.summary)
        return Motions(made, _backwards(made, report.summary))


def motion_fingerprint(specs: Specs, config: Config, last: str) -> str:
    """Hash what a motion depends on: configuration and code of the stages up to the last one, of all if it is unknown.

    Parameters
    ----------
    config : Config
        That of the pair, in the direction in which its run goes.
    """
    stages = STAGES if last not in STAGES else (*Stage(last).earlier, Stage(last))
    return config_sha256({stage: fingerprint(specs, stage, config, {}) for stage in stages})


def _record(run: str, last: Stage, summary: dict[str, Any]) -> MotionRecord:
    path, certificate, trajectory = (summary[key] for key in ("path", "certificate", "trajectory"))
    return MotionRecord(
        status="done",
        run=run,
        to=str(last),
        kappa_integral=path.get("kappa_integral"),
        kappa_max=path.get("kappa_max"),
        min_link_distance_m=path.get("min_link_distance_m"),
        verdict=certificate["verdict"],
        kappa_bound=certificate.get("kappa_bound"),
        duration_s=trajectory.get("duration_s"),
    )


def _backwards(made: MotionRecord, summary: dict[str, Any]) -> MotionRecord:
    """Give the record of the way back: the same path, with a time law of its own."""
    back = summary["trajectory"].get("back", {})
    changes: dict[str, object] = {"backwards": True, "duration_s": back.get("duration_s")}
    if (failure := failed_part(summary["trajectory"])) is not None:
        changes |= {"status": "failed", "to": "retime", "reason": failure["reason"], "advice": failure["advice"]}
    return made.model_copy(update=changes)
