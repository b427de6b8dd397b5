"""Motions to be played: in time, on the machine, from what a run has."""

from pathlib import Path

import numpy as np
import pytest

from pipeline.config import Config
from pipeline.errors import UsageError
from pipeline.export.csv import format_csv
from pipeline.machine import Machine
from pipeline.run.results import Results
from pipeline.show.playback import COARSE, REFINED, SIMULATED, Player, Track, simulated_track, tracks_of
from pipeline.stage import Stage
from tests.run.short_results import make_refinement, make_route, make_trajectory

POSE = ("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad")


@pytest.fixture
def results(quick_config: Config, machine: Machine, tmp_path: Path) -> Results:
    """Give a run with a route, a path and a trajectory."""
    run = Results(quick_config, machine, tmp_path)
    refinement = make_refinement(machine)
    run.keep(Stage.ROUTE, make_route(machine))
    run.keep(Stage.REFINE, refinement)
    run.keep(Stage.RETIME, make_trajectory(refinement.path))
    return run


def test_tracks_are_what_the_run_has(results: Results) -> None:
    """A route has its coarse path, a path is played evenly, and a trajectory in its own time."""
    route, path, timed = (
        tracks_of(results, frozenset(stages))
        for stages in (
            {Stage.ROUTE},
            {Stage.ROUTE, Stage.REFINE},
            {Stage.ROUTE, Stage.REFINE, Stage.RETIME},
        )
    )
    assert [track.name for track in route] == [COARSE]
    assert [track.name for track in timed] == [track.name for track in path] == [COARSE, REFINED]
    assert tracks_of(results, frozenset()) == []
    assert timed[1].duration_s == pytest.approx(results.trajectory.duration_s)
    assert timed[0].duration_s == pytest.approx(results.trajectory.duration_s)


def test_the_machine_is_where_the_trajectory_is(results: Results) -> None:
    """Samples close their links, and are those of the trajectory at their instants."""
    track = tracks_of(results, frozenset({Stage.ROUTE, Stage.REFINE, Stage.RETIME}))[1]
    assert track.samples.closure_residual_m.max() < 1e-9
    index = track.nearest(0.37 * track.duration_s)
    assert abs(track.t_s[index] - 0.37 * track.duration_s) <= 0.5 * np.diff(track.t_s).max() + 1e-9
    np.testing.assert_allclose(track.at(index).q_m[0], results.trajectory.q(track.t_s[index]))
    assert set(track.modes) == {"LLL"}


def test_a_simulated_motion_is_read(results: Results, tmp_path: Path) -> None:
    """A table with pose and actuators over time becomes a track; one without is refused with its name."""
    source = tracks_of(results, frozenset({Stage.ROUTE}))[0]
    file = tmp_path / "twin.csv"
    _write(source, file)
    track = simulated_track(results.machine, file)
    assert track.name == SIMULATED
    np.testing.assert_allclose(track.samples.q_m[[0, -1]], source.samples.q_m[[0, -1]], atol=1e-9)
    file.write_text("t_s,x_m\n0,1\n")
    with pytest.raises(UsageError, match=r"twin\.csv"):
        simulated_track(results.machine, file)


def _write(track: Track, file: Path) -> None:
    columns = {"t_s": track.t_s} | dict(zip(POSE, track.samples.pose.T, strict=True))
    columns |= {f"q{k + 1}_m": track.samples.q_m[:, k] for k in range(5)}
    file.write_text(format_csv(columns))


def test_time_runs_and_ends() -> None:
    """Time passes at its speed while it plays, stops at the end, and begins again from the start."""
    player = Player(2.0, speed=0.5)
    assert player.advanced(1.0).t_s == 0.0
    player = player.toggled().advanced(1.0)
    assert (player.t_s, player.playing) == (0.5, True)
    ended = player.advanced(10.0)
    assert (ended.t_s, ended.playing) == (2.0, False)
    assert (ended.toggled().t_s, ended.toggled().playing) == (0.0, True)
    assert (player.toggled().t_s, player.toggled().playing) == (0.5, False)
