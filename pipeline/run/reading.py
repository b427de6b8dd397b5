"""Results of a run that is over, for commands that look at them."""

from pathlib import Path

from pipeline.artifacts import Record, read_run_folder
from pipeline.config import Config
from pipeline.config.file import parse_config
from pipeline.errors import UsageError
from pipeline.machine.geometry import build_machine
from pipeline.run.stages import Results
from pipeline.stage import Stage


def open_results(folder: Path | str, *stages: Stage) -> Results:
    """Open the results of a run, of which those of `stages` are needed and must be as they were written.

    Those of other stages are loaded when first asked for, unchecked; a FileNotFoundError where there are none.

    Raises
    ------
    UsageError
        When the folder holds no run, or one of the stages has no result there.
    """
    folder = Path(folder)
    config, state = read_run_folder(folder)
    for stage in stages:
        record = state.stages.get(stage)
        if record is None:
            raise UsageError(
                f"{folder} has no result of {stage} yet.\n  What to change: run the pipeline up to there first."
            )
        if record.status == "failed":
            raise UsageError(f"{folder} has no result of {stage}, which failed: {record.summary['reason']}")
        refuse_damage(folder, record)
    return Results(config, build_machine(config.machine), folder)


def refuse_damage(folder: Path, record: Record) -> None:
    """Insist that the files of a stage are as they were written.

    Raises
    ------
    UsageError
        When they are not.
    """
    if damage := record.damage(folder):
        raise UsageError(
            f"{folder} has files that were removed or changed after the run: {', '.join(damage)}.\n"
            "  What to change: run the pipeline again; it makes what is damaged anew."
        )


def with_retime(config: Config, period_s: float | None = None, speed: float | None = None) -> Config:
    """Put another sampling period or another part of the speed into a configuration; None leaves them.

    Raises
    ------
    ConfigError
        When they are not within what the configuration allows.
    """
    given = {"period_s": period_s, "speed": speed}
    changes = {key: value for key, value in given.items() if value is not None}
    if not changes:
        return config
    data = config.model_dump(mode="json")
    data["retime"].update(changes)
    words = {"period_s": "a period of {:g} s", "speed": "a speed of {:g}"}
    return parse_config(data, source=" and ".join(words[key].format(value) for key, value in changes.items()))
