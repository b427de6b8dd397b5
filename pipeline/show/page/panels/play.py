"""Playing the motions of a run: which one, the time, and how fast."""

from dataclasses import replace
from time import monotonic
from typing import Any

from pipeline.machine.geometry import MODES
from pipeline.show.page.app import App, rounded_pose
from pipeline.show.playback import Player, Track
from pipeline.show.posture import readings_at
from pipeline.show.session import LoadedRun
from pipeline.show.words import message_html, moving_html, readings_html

_NOTHING = "nothing yet"
_SPEEDS = ("0.1", "0.25", "0.5", "1", "2", "4")
_NO_RUN = "There is no motion yet: plan one, or open the folder of a run with gantry-tau show RUN."


class PlayPanel:
    """Controls of a motion that is played.

    Attributes
    ----------
    tracks : tuple of Track
        The motions there are, all of one machine.
    """

    def __init__(self, app: App) -> None:
        self._app = app
        self.tracks: tuple[Track, ...] = ()
        self._config = app.session.config.machine
        self._player = Player(0.0)
        self._then = 0.0
        gui = app.server.gui
        self._which: Any = gui.add_dropdown("motion", (_NOTHING,))
        self._time: Any = gui.add_slider("time (s)", 0.0, 1.0, 0.01, 0.0, disabled=True)
        self._speed: Any = gui.add_dropdown("speed", _SPEEDS, initial_value="1")
        self._play: Any = gui.add_button("Play / pause", disabled=True)
        self._take: Any = gui.add_button("Jog from here", disabled=True, hint="To take this pose for the task")
        self._note: Any = gui.add_html(message_html(_NO_RUN))

        async def chosen(event: Any) -> None:
            if event.client is not None:
                app.jobs.post_every(self._choose)

        async def scrubbed(event: Any) -> None:
            if event.client is not None:
                app.jobs.post("jog", self._scrub)

        async def sped(event: Any) -> None:
            if event.client is not None:
                app.jobs.post_every(self._change_speed)

        async def toggled(_: Any) -> None:
            app.jobs.post_every(self._toggle)

        async def taken(_: Any) -> None:
            app.jobs.post_every(self._jog_from_here)

        self._take.on_click(taken)
        self._which.on_update(chosen)
        self._time.on_update(scrubbed)
        self._speed.on_update(sped)
        self._play.on_click(toggled)
        app.after_edit.append(self._forget_other_machine)

    def load(self, run: LoadedRun) -> None:
        """Take over the motions of a run, the last one chosen."""
        self._config = run.results.config.machine
        self._show(run.tracks, run.failure)

    def add(self, track: Track) -> None:
        """Add a motion of the machine as it is, and choose it."""
        self._config = self._app.session.config.machine
        self._show((*(other for other in self.tracks if other.name != track.name), track), "")

    def _show(self, tracks: tuple[Track, ...], failure: str) -> None:
        """Offer motions, and say what failed."""
        self.tracks = tracks
        self._app.view.draw_tracks(tracks)
        names = tuple(track.name for track in tracks) or (_NOTHING,)
        self._which.options, self._which.value = names, names[-1]
        self._choose()
        if failure:
            self._note.content = message_html(failure, wrong=True)

    @property
    def _track(self) -> Track | None:
        return next((track for track in self.tracks if track.name == self._which.value), None)

    def _choose(self) -> None:
        track = self._track
        self._app.tick = None
        self._time.disabled = self._play.disabled = self._take.disabled = track is None
        if track is None:
            self._note.content = message_html(_NO_RUN)
            return
        self._player = Player(track.duration_s, speed=float(self._speed.value))
        self._time.max, self._time.value = round(track.duration_s, 2), 0.0
        self._note.content = message_html(f"{track.name}, {track.duration_s:.2f} s: {track.note}")

    def _change_speed(self) -> None:
        self._player = replace(self._player, speed=float(self._speed.value))

    def _toggle(self) -> None:
        if self._track is None:
            return
        self._player = self._player.toggled()
        self._then = monotonic()
        self._app.tick = self._tick if self._player.playing else None

    def _jog_from_here(self) -> None:
        track = self._track
        if track is not None:
            index = track.nearest(self._player.t_s)
            pose = track.samples.pose[index]
            self._player = replace(self._player, playing=False)
            self._app.jog(rounded_pose(pose[:3], (pose[3], pose[5]), track.modes[index]))

    def _scrub(self) -> None:
        self._player = replace(self._player, t_s=min(float(self._time.value), self._player.duration_s), playing=False)
        self._app.tick = None
        self._draw()

    def _tick(self) -> None:
        now = monotonic()
        self._player, self._then = self._player.advanced(now - self._then), now
        self._time.value = round(self._player.t_s, 2)
        if not self._player.playing:
            self._app.tick = None
        self._draw()

    def _draw(self) -> None:
        """Show the machine at the instant."""
        track, app = self._track, self._app
        if track is None:
            return
        index = track.nearest(self._player.t_s)
        samples, mode = track.at(index), track.modes[index]
        readings = readings_at(app.session.config, samples.machine, samples)
        sides = tuple(-1.0 if letter == "L" else 1.0 for letter in mode)
        title = f"{track.name}, {track.t_s[index]:.2f} s, {mode}, kappa {samples.kappa[0]:.3f}."
        with app.server.atomic():
            app.view.move_machine(samples.machine, samples, sides, any(one.room < 0.0 for one in readings))
            app.view.tool.visible = False
            app.status.content = moving_html(title, readings) + readings_html(readings)
        app.ask_map(samples, MODES.index(mode))

    def _forget_other_machine(self) -> None:
        if self.tracks and self._config != self._app.session.config.machine:
            self._show((), "")
