"""What the process does that plans: run the stages, and tell what happens."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from pipeline.config.file import load_config
from pipeline.errors import PipelineError
from pipeline.progress import Progress
from pipeline.run import RunOptions, run_pipeline
from pipeline.stage import Stage

Tell = Callable[[dict[str, Any]], None]
STOPPED = "stopped: finished stages are kept"


class _Telling:
    """Tells what a run reports."""

    def __init__(self, tell: Tell) -> None:
        self._tell = tell

    def begin(self, stage: Stage) -> Progress:
        self._tell({"stage": stage, "message": "started"})

        def progress(message: str, fraction: float | None = None) -> None:
            self._tell({"stage": stage, "message": message.removeprefix(f"{stage}: "), "fraction": fraction})

        return progress

    def end(self, stage: Stage, outcome: str, seconds: float) -> None:
        self._tell({"stage": stage, "message": f"{outcome} ({seconds:.1f} s)"})


def plan(file: Path, folder: Path, last: str, tell: Tell) -> None:
    """Run the stages of a configuration up to one; tell what happens, and at last `failure`: empty if all went well."""
    try:
        report = run_pipeline(load_config(file), folder, RunOptions(last=Stage(last)), _Telling(tell))
        report.require_complete()
        failure = ""
    except PipelineError as error:
        failure = "\n".join([str(error), *getattr(error, "__notes__", [])])
    except OSError as error:
        failure = str(error)
    except KeyboardInterrupt:
        failure = STOPPED
    tell({"failure": failure})
