"""What the page knows: the configuration as it was changed, the machine as it stands, and the run that is played."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from pipeline.artifacts.state import read_state
from pipeline.config import Config, PoseConfig
from pipeline.errors import UsageError
from pipeline.machine.geometry import Machine, build_machine
from pipeline.run.reading import open_results
from pipeline.run.results import Results
from pipeline.show.playback import Track, tracks_of
from pipeline.show.posture import Posture, first_posture, in_reach, place_machine
from pipeline.show.saving import is_saved, save_config
from pipeline.stage import STAGES, Stage


@dataclass(frozen=True, eq=False)
class LoadedRun:
    """A run: its folder, its results, the stages that are done, its motions, and why it went no further."""

    folder: Path
    results: Results
    done: frozenset[Stage]
    tracks: tuple[Track, ...]
    failure: str


class Session:
    """The state of the page; every change keeps it valid, or raises and changes nothing.

    Attributes
    ----------
    config : Config
        The configuration as it was changed.
    machine : Machine
        Its machine.
    posture : Posture
        The machine as it was jogged last.
    file : Path
        Where the configuration is read from, or to be saved.
    """

    def __init__(self, config: Config, file: Path) -> None:
        self.config = config
        self.machine: Machine = build_machine(config.machine)
        self.posture: Posture = first_posture(config, self.machine)
        self.file = file

    def jog(self, asked: PoseConfig) -> Posture:
        """Place the machine at a pose."""
        self.posture = place_machine(self.config, self.machine, asked, self.posture.samples)
        return self.posture

    def edit(self, change: Callable[[Config], Config]) -> None:
        """Change the configuration; where its machine is another one, it stands at the same pose if it can.

        Raises
        ------
        ConfigError
            When the new one is not allowed, or its machine can be nowhere.
        """
        config = change(self.config)
        machine = self.machine if config.machine == self.config.machine else build_machine(config.machine)
        asked = self.posture.asked
        samples = self.posture.samples if machine is self.machine else in_reach(machine, asked)
        posture = first_posture(config, machine) if samples is None else place_machine(config, machine, asked, samples)
        self.config, self.machine, self.posture = config, machine, posture

    def save(self, path: Path, replace: bool) -> None:
        """Save the configuration; it is then called like the file.

        Raises
        ------
        UsageError
            When the file is there and not to be replaced, or its name is none of a configuration.
        OSError
            When it cannot be written.
        """
        self.config = save_config(self.config, path, replace)
        self.file = path

    def require_file(self, path: Path, replace: bool) -> None:
        """Save the configuration unless the file holds it already; raises what `save` raises."""
        if is_saved(self.config, path):
            self.file = path
        else:
            self.save(path, replace)


def load_run(folder: Path) -> LoadedRun:
    """Open a run folder with whatever stages are done.

    Raises
    ------
    UsageError
        When it is not a run folder, or files of a stage were changed.
    PipelineError
        When a path cannot be followed.
    """
    results = open_results(folder)
    state = read_state(folder)
    records = {} if state is None else state.stages
    done = frozenset(stage for stage in STAGES if stage in records and records[stage].status == "done")
    open_results(folder, *(stage for stage in STAGES if stage in done and stage is not Stage.FIGURES))
    failed = [stage for stage in STAGES if stage in records and records[stage].status == "failed"]
    failure = ""
    if failed:
        section = records[failed[0]].summary
        advice = f" What to change: {section['advice']}" if section.get("advice") else ""
        failure = f"{failed[0]} failed: {section.get('reason')}.{advice}"
    return LoadedRun(folder, results, done, tuple(tracks_of(results, done)), failure)


def is_run_folder(path: Path) -> bool:
    """Check whether a path is a folder, which is then to be one of a run.

    Raises
    ------
    UsageError
        When there is nothing.
    """
    if not path.exists():
        raise UsageError(f"{path} does not exist: give a CONFIG file or the folder of a run")
    return path.is_dir()
