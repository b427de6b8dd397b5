"""Motions of a run to be played: where the machine is at every instant, and how time runs."""

from dataclasses import dataclass, replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.errors import UsageError
from pipeline.export.trajectory_columns import POSE
from pipeline.machine.geometry import ACTUATORS, Machine
from pipeline.machine.samples import PoseSamples
from pipeline.machine.working_modes import mode_names, working_modes
from pipeline.measured.reading import read_table
from pipeline.measured.reading.decoding import read_bytes
from pipeline.measured.table import TIME
from pipeline.stage import Stage

if TYPE_CHECKING:
    from pipeline.refine.result import Path
    from pipeline.retime.result import Trajectory
    from pipeline.run.results import Results

COARSE, REFINED, SIMULATED = "coarse path", "refined path", "simulated motion"
_FRAMES_PER_S, _FEWEST, _MOST = 50.0, 200, 3_000
_UNTIMED_S = 10.0
"""What a path takes that has no time law."""


@dataclass(frozen=True, eq=False)
class Track:
    """A motion as samples.

    Attributes
    ----------
    name : str
        What it is.
    t_s : (n,)
        Instants, increasing from zero.
    samples : PoseSamples
        The machine there.
    modes : n texts
        Working modes.
    note : str
        What its time is.
    """

    name: str
    t_s: FloatArray
    samples: PoseSamples
    modes: tuple[str, ...]
    note: str

    @property
    def duration_s(self) -> float:
        """The last instant."""
        return float(self.t_s[-1])

    def nearest(self, t_s: float) -> int:
        """Find the sample nearest to an instant."""
        return int(np.abs(self.t_s - t_s).argmin())

    def at(self, index: int) -> PoseSamples:
        """Give the machine at a sample (n = 1)."""
        return self.samples.take(np.array([index]))


@dataclass(frozen=True)
class Player:
    """How time runs along a track that takes `duration_s`."""

    duration_s: float
    t_s: float = 0.0
    speed: float = 1.0
    playing: bool = False

    def advanced(self, seconds: float) -> "Player":
        """Let time pass, to the end at most."""
        t_s = min(self.t_s + self.speed * seconds, self.duration_s) if self.playing else self.t_s
        return replace(self, t_s=t_s, playing=self.playing and t_s < self.duration_s)

    def toggled(self) -> "Player":
        """Begin, from the start if it is at the end, or pause."""
        at_end = not self.playing and self.t_s >= self.duration_s
        return replace(self, playing=not self.playing, t_s=0.0 if at_end else self.t_s)


def tracks_of(results: "Results", stages: frozenset[Stage]) -> list[Track]:
    """Collect the motions of a run whose `stages` are done: its coarse path, and its refined path, in time if timed.

    Raises
    ------
    PipelineError
        When a path cannot be followed.
    """
    from pipeline.refine.coarse import coarse_path
    from pipeline.route.metric import step_sizes

    tracks = []
    trajectory = results.trajectory if Stage.RETIME in stages else None
    duration_s = _UNTIMED_S if trajectory is None else trajectory.duration_s
    if Stage.ROUTE in stages:
        coarse = coarse_path(results.machine, results.route, step_sizes(results.config.route))
        note = "the steps of the route joined by straight moves of the actuators, at an even pace: it has no time law"
        tracks.append(_path_track(COARSE, coarse, duration_s, note))
    if trajectory is not None:
        tracks.append(_trajectory_track(trajectory))
    elif Stage.REFINE in stages:
        tracks.append(_path_track(REFINED, results.refinement.path, duration_s, "at an even pace: it is not timed yet"))
    return tracks


def simulated_track(machine: Machine, file: FilePath) -> Track:
    """Read a motion that `gantry-tau simulate --output` has written.

    Raises
    ------
    UsageError
        When it is not one.
    OSError
        When it cannot be read.
    """
    columns = (TIME, *POSE, *(f"q{k + 1}_m" for k in range(len(ACTUATORS))))
    found = read_table(read_bytes(file), str(file), (columns,)).columns
    t_s, *rest = (found[name] for name in columns)
    if not (np.diff(t_s) > 0.0).all():
        raise UsageError(f"{file}: its times do not increase; expected a motion written by gantry-tau simulate")
    every = max(1, len(t_s) // _MOST)
    rows = np.unique(np.append(np.arange(0, len(t_s), every), len(t_s) - 1))
    values = np.stack(rest, axis=1)[rows]
    return _track(SIMULATED, t_s[rows] - t_s[0], PoseSamples(machine, values[:, :6], values[:, 6:]), "as simulated")


def _trajectory_track(trajectory: "Trajectory") -> Track:
    t_s = _instants(trajectory.duration_s)
    samples = PoseSamples(trajectory.path.machine, trajectory.pose(t_s), trajectory.q(t_s))
    return _track(REFINED, t_s, samples, "as the controller drives it")


def _path_track(name: str, path: "Path", duration_s: float, note: str) -> Track:
    t_s = _instants(duration_s)
    s = t_s / t_s[-1]
    return _track(name, t_s, PoseSamples(path.machine, path.pose(s), path.q(s)), note)


def _instants(duration_s: float) -> FloatArray:
    count = int(np.clip(np.ceil(duration_s * _FRAMES_PER_S), _FEWEST, _MOST))
    return np.linspace(0.0, duration_s, count + 1)


def _track(name: str, t_s: FloatArray, samples: PoseSamples, note: str) -> Track:
    return Track(name, t_s, samples, tuple(mode_names(working_modes(samples.reach_m))), note)
