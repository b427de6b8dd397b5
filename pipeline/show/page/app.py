"""The page at work: what was asked for is done, one thing at a time, and what follows from it is shown."""

import math
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from pipeline.arrays import FloatArray
from pipeline.config import Config, PoseConfig
from pipeline.errors import PipelineError
from pipeline.machine.geometry import MODES
from pipeline.machine.pose import TILT_COLUMNS
from pipeline.machine.samples import PoseSamples
from pipeline.show.edits import task_refusals
from pipeline.show.jobs import Jobs
from pipeline.show.map_picture import map_picture
from pipeline.show.page.scene import SceneView
from pipeline.show.posture import modes_in_reach
from pipeline.show.session import Session
from pipeline.show.words import message_html, modes_html, pose_html, readings_html, task_html, verdict_html

if TYPE_CHECKING:
    from viser import ViserServer

_MAP, _CHECK = "map", "check"
_PANEL_PX = 390
TICK_S = 1.0 / 30.0
"""Time between two pictures of a motion."""

Follow = Callable[[], None]


class App:
    """Shared by all panels of the page.

    Attributes
    ----------
    server : ViserServer
        The server.
    session : Session
        What the page knows.
    jobs : Jobs
        What it is asked for.
    view : SceneView
        What is seen in 3-D.
    after_jog, after_edit : list of callables
        What panels do once the machine was jogged, or the configuration was changed.
    tick : callable or None
        What is done again and again while a motion is played.
    jog_ms : float
        What the last jog took.
    """

    def __init__(self, server: "ViserServer", session: Session) -> None:
        self.server = server
        self.session = session
        self.jobs = Jobs(_CHECK, _MAP)
        self.view = SceneView(server)
        self.after_jog: list[Follow] = []
        self.after_edit: list[Follow] = []
        self.tick: Follow | None = None
        self.jog_ms = 0.0
        self._mapped: tuple[float, float, int] | None = None
        self._notice: Any = server.gui.add_html("")
        state = server.gui.add_panel()
        with state.add_tab("At this pose"):
            self.status: Any = server.gui.add_html("")
        state.dock_left()
        state.set_width(_PANEL_PX)
        server.gui.main_panel.dock_right()
        server.gui.main_panel.set_width(_PANEL_PX)
        self.task_status: Any = None

    def begin(self) -> None:
        """Draw everything for the first time."""
        self.view.draw_machine(self.session.config, self.session.machine)
        self.view.place_camera(self.session.machine)
        self.follow_edit()

    def run(self) -> None:
        """Do what is asked for until the process is interrupted."""
        began = time.monotonic()
        while True:
            if self.tick is None:
                job = self.jobs.take()
            else:
                job = self.jobs.take(max(began + TICK_S - time.monotonic(), 0.0))
                if time.monotonic() >= began + TICK_S:
                    began = time.monotonic()
                    self.tick()
            if job is not None:
                self.attempt(job)

    def attempt(self, job: Follow) -> None:
        """Do something; what the user can mend is told, and nothing else is caught."""
        self._notice.content = ""
        try:
            job()
        except (PipelineError, OSError) as error:
            self.tell(str(error))

    def tell(self, text: str) -> None:
        """Show what is wrong to whoever looks at the page."""
        self._notice.content = message_html(text, wrong=True)
        for client in self.server.get_clients().values():
            client.add_notification("That cannot be done", text, color="red", auto_close_seconds=10.0)

    def ask_jog(self, pose: PoseConfig) -> None:
        """Ask for the machine at a pose, in place of the last one asked for."""
        self.jobs.post("jog", lambda: self.jog(pose))

    def jog(self, pose: PoseConfig) -> None:
        """Place the machine at a pose, and show it."""
        began = time.perf_counter()
        self.tick = None
        self.session.jog(pose)
        self.follow_jog()
        self.jog_ms = 1e3 * (time.perf_counter() - began)

    def follow_jog(self) -> None:
        """Show the machine as it was jogged last."""
        session, posture = self.session, self.session.posture
        modes = modes_in_reach(session.machine, posture.asked)
        with self.server.atomic():
            self.view.move_machine(session.machine, posture.samples, posture.sides, bool(posture.refusals))
            self.status.content = (
                verdict_html(posture)
                + pose_html(posture)
                + modes_html(modes, posture.asked.mode)
                + readings_html(posture.readings)
            )
            for follow in self.after_jog:
                follow()
        self.ask_map(posture.samples, MODES.index(posture.asked.mode))

    def edit(self, change: Callable[[Config], Config]) -> None:
        """Change the configuration, and show what follows."""
        before = self.session.machine
        self.session.edit(change)
        if self.session.machine is not before:
            self._mapped = None
            self.view.forget_map()
            self.view.draw_machine(self.session.config, self.session.machine)
        self.follow_edit()

    def follow_edit(self) -> None:
        """Show the configuration and the machine as they are."""
        self.view.draw_task(self.session.config, self.session.machine)
        for follow in self.after_edit:
            follow()
        self.follow_jog()
        self.jobs.post(_CHECK, self._check)

    def ask_map(self, samples: PoseSamples, mode: int) -> None:
        """Ask for the map of kappa at the tilt of the machine in a working mode."""
        rx, rz = samples.pose[0, TILT_COLUMNS].tolist()
        self.jobs.post(_MAP, lambda: self._draw_map((rx, rz), mode, float(samples.pose[0, 0])))

    def _draw_map(self, tilt_rad: tuple[float, float], mode: int, x_m: float) -> None:
        wanted = (*tilt_rad, mode)
        if self._mapped == wanted:
            return
        picture = map_picture(self.session.config, self.session.machine, tilt_rad, mode)
        with self.server.atomic():
            self.view.draw_map(picture, x_m)
        self._mapped = wanted

    def _check(self) -> None:
        if self.task_status is not None:
            session = self.session
            self.task_status.content = task_html(session.config, task_refusals(session.config, session.machine))


def rounded_pose(position: Sequence[float] | FloatArray, tilts_rad: tuple[float, float], mode: str) -> PoseConfig:
    """Make a pose of a place and tilts, to a tenth of a millimetre and a hundredth of a degree."""
    x, y, z = (max(-20.0, min(20.0, round(float(value), 4))) for value in position)
    rx, rz = (max(-85.0, min(85.0, round(math.degrees(value), 2))) for value in tilts_rad)
    return PoseConfig(x_m=x, y_m=y, z_m=z, rx_deg=rx + 0.0, rz_deg=rz + 0.0, mode=mode)
