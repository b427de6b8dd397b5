"""Jogging: sliders, working mode, and the tool that is dragged."""

from typing import Any

import numpy as np

from pipeline.config import PoseConfig
from pipeline.machine.geometry import MODES
from pipeline.machine.pose import TILT_AXES
from pipeline.show.map_picture import map_window
from pipeline.show.orientation import tilt_quaternion, tilts_of
from pipeline.show.page.app import App, rounded_pose
from pipeline.show.words import note_html

_BEYOND_DEG, _MOST_DEG = 10.0, 85.0
"""How far sliders go beyond the tilts that the task allows, so that one sees why it ends there."""
_KEYS = ("x_m", "y_m", "z_m", "rx_deg", "rz_deg")
_LEGEND = (
    "The coloured arrows and arcs at the tool drag and tilt it. On the map of kappa dark is near a singularity, yellow "
    "is det H = 0. Blue arms are left, orange ones right; red: not allowed here."
)


class JogPanel:
    """Sliders, the working mode, and the gizmo at the TCP."""

    def __init__(self, app: App) -> None:
        self._app = app
        gui = app.server.gui
        self._sliders: dict[str, Any] = {}
        for key, (least, largest) in _ranges(app).items():
            name, unit = key.rsplit("_", 1)
            step = 0.001 if unit == "m" else 0.1
            self._sliders[key] = gui.add_slider(f"{name} ({unit})", least, largest, step, least)
        self._mode: Any = gui.add_dropdown("working mode", MODES, hint="L or R for arms 1, 2, 3: where the cart is")
        self._shown: Any = gui.add_checkbox("map of kappa", initial_value=True, hint="At the x of the TCP")
        gui.add_html(note_html(_LEGEND))
        self._gizmo: Any = app.view.tool
        self._dragged = False
        for control in (*self._sliders.values(), self._mode):
            control.on_update(self._by_control)
        self._shown.on_update(self._by_box)
        self._gizmo.on_update(self._by_gizmo)
        app.after_jog.append(self._follow_jog)
        app.after_edit.append(self._follow_edit)

    async def _by_control(self, event: Any) -> None:
        # What the program itself sets has no client.
        if event.client is not None:
            given = {key: slider.value for key, slider in self._sliders.items()}
            self._app.ask_jog(PoseConfig(mode=self._mode.value, **given))

    async def _by_gizmo(self, event: Any) -> None:
        self._dragged = event.phase != "end"
        self._app.ask_jog(rounded_pose(self._gizmo.position, tilts_of(self._gizmo.wxyz), self._mode.value))

    async def _by_box(self, event: Any) -> None:
        if event.client is not None:
            self._app.jobs.post("visible", lambda: self._app.view.show_map(self._shown.value))

    def _follow_jog(self) -> None:
        """Set the controls to the pose that was asked for; the gizmo is where the machine is, unless it is dragged."""
        posture = self._app.session.posture
        for key, slider in self._sliders.items():
            slider.value = getattr(posture.asked, key)
        self._mode.value = posture.asked.mode
        self._gizmo.visible = True
        if not self._dragged:
            pose = posture.samples.pose[0]
            self._gizmo.position, self._gizmo.wxyz = pose[:3], tilt_quaternion(pose)

    def _follow_edit(self) -> None:
        for key, (least, largest) in _ranges(self._app).items():
            self._sliders[key].min, self._sliders[key].max = least, largest


def _ranges(app: App) -> dict[str, tuple[float, float]]:
    """Give the ends of every slider: rails, the picture of the map, and tilts, each with something beyond."""
    config, travel = app.session.config, app.session.machine.travel_m
    window = map_window(config, app.session.machine)
    tilts = [0.0 if axis in config.task.locked_axes else config.task.tilt_max_deg for axis in TILT_AXES]
    # The TCP may be beyond the ends of the rails by as much as arms reach ahead of their carts.
    ahead_m = float(np.nanmax(app.session.machine.lengths_m))
    ends = [
        (travel[:, 0].min() - ahead_m, travel[:, 1].max() + ahead_m),
        (window.y_least, window.y_largest),
        (window.z_least, window.z_largest),
        *((-min(tilt + _BEYOND_DEG, _MOST_DEG), min(tilt + _BEYOND_DEG, _MOST_DEG)) for tilt in tilts),
    ]
    asked = app.session.posture.asked
    return {
        key: (round(min(float(least), getattr(asked, key)), 3), round(max(float(largest), getattr(asked, key)), 3))
        for key, (least, largest) in zip(_KEYS, ends, strict=True)
    }
