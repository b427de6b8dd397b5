"""What the second process does: every part as soon as the results are there that it needs."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from pipeline.artifacts.layout import REPORT
from pipeline.artifacts.state import State, read_state
from pipeline.config.file import parse_config
from pipeline.figures import FIGURES
from pipeline.machine.geometry import build_machine
from pipeline.run.makers.pictures import last_stage, picture
from pipeline.run.makers.report_page import report_page
from pipeline.run.makers.report_parts import coarse_motion, measured_paths, workspace
from pipeline.run.results import Results
from pipeline.stage import Stage

Files = dict[str, bytes]


@dataclass(frozen=True)
class Part:
    """A part of the work: the stage that has to be done before, or None, and what makes its files.

    Parts without files prepare the report.
    """

    name: str
    after: Stage | None
    make: Callable[[Results], Files]


def _prepare(compute: Callable[[Results], object], after: Stage | None) -> Part:
    def make(results: Results) -> Files:
        results.derive(compute)
        return {}

    return Part(compute.__name__, after, make)


def _page(results: Results) -> Files:
    return {REPORT: report_page(results, read_state(results.folder) or State())}


PARTS = (
    _prepare(workspace, None),
    _prepare(coarse_motion, Stage.ROUTE),
    _prepare(measured_paths, Stage.REFINE),
    Part(REPORT, Stage.RETIME, _page),
    *(Part(figure.name, last_stage(figure), partial(picture, figure)) for figure in FIGURES),
)
"""All parts; of those that can be made, the first is."""


def work(
    folder: Path, next_line: Callable[[], bytes], more_lines: Callable[[], bool], write: Callable[[bytes], None]
) -> None:
    """Make figures and the report of a run folder, and write each as soon as it is made.

    A part begins with a line of JSON, its name and `null`, and ends with another, its name and the sizes of its files
    by name, before their bytes.

    Parameters
    ----------
    next_line : callable
        Waits for a line: first the configuration as JSON, then `done STAGE` and, of parts that the run makes itself,
        `taken PART`.
    more_lines : callable
        Whether there is one already.
    write : callable
        Writes to the run.
    """
    config = parse_config(json.loads(next_line()))
    results = Results(config, build_machine(config.machine), folder)
    waiting, done = list(PARTS), set[Stage | None]([None])
    while waiting:
        ready = next((part for part in waiting if part.after in done), None)
        if ready is None or more_lines():
            word, name = next_line().decode().split()
            if word == "done":
                done.add(Stage(name))
            else:
                waiting = [part for part in waiting if part.name != name]
            continue
        waiting.remove(ready)
        write(_line(ready.name, None))
        files = ready.make(results)
        write(_line(ready.name, {name: len(content) for name, content in files.items()}) + b"".join(files.values()))


def _line(part: str, sizes: dict[str, int] | None) -> bytes:
    return json.dumps([part, sizes]).encode() + b"\n"
