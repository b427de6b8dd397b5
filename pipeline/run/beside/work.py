"""What the second process does: the first part at once, the rest when it is asked."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO

from pipeline.artifacts.layout import REPORT
from pipeline.artifacts.state import State, read_state
from pipeline.config.file import parse_config
from pipeline.machine.geometry import build_machine
from pipeline.run.makers.pictures import early_pictures
from pipeline.run.makers.report_page import report_page
from pipeline.run.makers.report_parts import coarse_motion, workspace
from pipeline.run.results import Results


def work(folder: Path, next_line: Callable[[], bytes], output: BinaryIO) -> None:
    """Make figures and the report of a run folder, and write them as one line of JSON, name to size, and their bytes.

    Parameters
    ----------
    next_line : callable
        Waits for a line: first the configuration as JSON, then the request for the rest.
    """
    config = parse_config(json.loads(next_line()))
    results = Results(config, build_machine(config.machine), folder)
    results.derive(coarse_motion)
    results.derive(workspace)
    files = early_pictures(results)
    next_line()
    files[REPORT] = report_page(results, read_state(folder) or State())
    output.write(json.dumps({name: len(content) for name, content in files.items()}).encode() + b"\n")
    output.writelines(files.values())
    output.flush()
