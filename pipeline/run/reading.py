"""The results of a finished run, for commands that evaluate them."""

from pathlib import Path
from typing import TYPE_CHECKING

from pipeline.artifacts import Record, read_run_folder
from pipeline.artifacts.layout import CERTIFICATE_JSON
from pipeline.config import Config
from pipeline.config.file import parse_config
from pipeline.errors import UsageError
from pipeline.machine.geometry import build_machine
from pipeline.run.results import Results
from pipeline.stage import Stage

if TYPE_CHECKING:
    from pipeline.certify.recheck.tube import ProvenTube


def open_results(folder: Path | str, *stages: Stage) -> Results:
    """Open the results of a run; those of `stages` must exist, with files as they were written.

    Those of other stages are loaded when first used, unchecked; a FileNotFoundError if there are none.

    Raises
    ------
    UsageError
        When the folder is not a run folder, or one of the stages has no result there.
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
            raise UsageError(f"{folder} has no result of {stage}, which failed: {record.summary.get('reason')}")
        refuse_damage(folder, record)
    return Results(config, build_machine(config.machine), folder)


def open_tubes(folder: Path | str) -> "tuple[ProvenTube, ...]":
    """Open how far the actuators of a run may be off its path, as `proven_tubes` gives it; none if that is not proven.

    Raises
    ------
    UsageError
        When the folder is not a run folder, or its certificate is damaged.
    """
    from pipeline.certify import path_sha256
    from pipeline.certify.recheck.tube import proven_tubes

    _, state = read_run_folder(Path(folder))
    record = state.stages.get(Stage.CERTIFY)
    if record is None or record.status == "failed" or CERTIFICATE_JSON not in record.files:
        return ()
    results = open_results(folder, Stage.REFINE, Stage.CERTIFY)
    stated = results.certificate
    if stated.path_sha256 != path_sha256(results.refinement.path):
        return ()
    return proven_tubes(stated.chains)


def refuse_damage(folder: Path, record: Record) -> None:
    """Require that the files of a stage are as they were written.

    Raises
    ------
    UsageError
        When they are not.
    """
    if damage := record.damage(folder):
        raise UsageError(
            f"{folder} has files that were removed or changed after the run: {', '.join(damage)}.\n"
            "  What to change: run the pipeline again; it makes damaged results again."
        )


def with_retime(config: Config, period_s: float | None = None, speed: float | None = None) -> Config:
    """Give the configuration with another sampling period or another part of the speed; None changes nothing.

    Raises
    ------
    ConfigError
        When the configuration does not allow them.
    """
    given = {"period_s": period_s, "speed": speed}
    changes = {key: value for key, value in given.items() if value is not None}
    if not changes:
        return config
    data = config.model_dump(mode="json")
    data["retime"].update(changes)
    words = {"period_s": "a period of {:g} s", "speed": "a speed of {:g}"}
    return parse_config(data, source=" and ".join(words[key].format(value) for key, value in changes.items()))


def with_pdf(config: Config) -> Config:
    """Give the configuration with figures as PDF, too."""
    return config.model_copy(update={"figures": config.figures.model_copy(update={"pdf": True})})
