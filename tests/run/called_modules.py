"""Run one stage, and print the modules of the package whose functions it really calls, as JSON.

python -m tests.run.called_modules CONFIG FOLDER STAGE
"""

import json
import sys
import threading
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import FrameType
from typing import Any

from pipeline.config.file import load_config
from pipeline.run import Results, RunOptions, run_pipeline
from pipeline.run.stage_specs import SPECS, StageSpec
from pipeline.run.up_to_date.source_code import PACKAGE
from pipeline.stage import Stage


class CallRecorder:
    """Notes which files have functions that are called, except while a module is imported."""

    def __init__(self) -> None:
        self.files: set[str] = set()
        self._others: set[str] = set()
        self._imports = threading.local()

    def __call__(self, frame: FrameType, event: str, _: Any) -> Any:
        """Take note of a call; only the end of an import is followed further."""
        code = frame.f_code
        if code.co_filename in self.files or code.co_filename in self._others:
            return None
        if not code.co_filename.startswith(str(PACKAGE)):
            self._others.add(code.co_filename)
            return None
        depth = getattr(self._imports, "depth", 0)
        if code.co_name == "<module>":
            self._imports.depth = depth + 1
            frame.f_trace_lines = False
            return self._end_of_import
        if depth == 0 and code.co_filename.endswith(".py"):
            self.files.add(code.co_filename)
        return None

    def _end_of_import(self, frame: FrameType, event: str, _: Any) -> Any:
        if event == "return":
            self._imports.depth -= 1
        return self._end_of_import

    def record(self, function: Callable[[], Any]) -> Any:
        """Call a function, and take note of what it calls, in all threads."""
        threading.settrace(self)
        sys.settrace(self)
        try:
            return function()
        finally:
            sys.settrace(None)
            threading.settrace(None)  # type: ignore[arg-type]  # None ends it, which typeshed does not know


def module_name(file: str) -> str:
    """Give the module that is in a file."""
    return ".".join([PACKAGE.name, *Path(file).relative_to(PACKAGE).with_suffix("").parts]).removesuffix(".__init__")


def recorded(spec: StageSpec, recorder: CallRecorder) -> StageSpec:
    """Record what the maker of a stage calls, and what puts its section into words and into the summary."""

    def make(results: Results, monitor: Any) -> Any:
        def everything() -> Any:
            product = spec.make(results, monitor)
            spec.words(spec.in_summary(product.section))
            return product

        return recorder.record(everything)

    return replace(spec, make=make)


def main(config: str, folder: str, stage: str) -> None:
    """Run the stage on earlier results in the folder."""
    recorder, only = CallRecorder(), Stage(stage)
    specs = tuple(recorded(spec, recorder) if spec.stage is only else spec for spec in SPECS)
    run_pipeline(load_config(config), folder, RunOptions(last=only), specs=specs)
    print(json.dumps(sorted(map(module_name, recorder.files))))  # noqa: T201


if __name__ == "__main__":
    main(*sys.argv[1:])
