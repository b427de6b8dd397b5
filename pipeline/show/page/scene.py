"""What is seen in 3-D: the machine, the map of kappa, the task, and paths."""

from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.config import Config
from pipeline.figures import style
from pipeline.figures.maps.kappa_map import YzWindow
from pipeline.limits.bodies.obstacle_distance import obstacles_of
from pipeline.machine.drawing import drawn_points, rail_ends
from pipeline.machine.geometry import Machine
from pipeline.machine.samples import PoseSamples
from pipeline.machine.shapes.model import FrameKind
from pipeline.show.map_picture import MapPicture, map_window
from pipeline.show.marks import shown_box, task_marks
from pipeline.show.page.bodies import draw_bodies, move_bodies
from pipeline.show.playback import COARSE, REFINED, SIMULATED, Track
from pipeline.show.rods import PLATFORM, arm_colours, machine_rods, rail_rods, rgb, rod_count, unit_cylinder

if TYPE_CHECKING:
    from viser import ViserServer

_AVOIDED = (200, 60, 40)
_CART_M = (0.12, 0.07, 0.05)
_TRACK_COLOURS = {COARSE: style.BLACK, REFINED: style.VERMILLION, SIMULATED: style.PURPLE}
_FACING = (0.5, 0.5, 0.5, 0.5)
"""Turns a picture's right and up to y and z, so that it faces +X."""


class SceneView:
    """The scene of a server; every `draw_` replaces what it drew before. `tool` is the gizmo at the TCP."""

    def __init__(self, server: "ViserServer") -> None:
        self._server = server
        self._scene = server.scene
        self._nodes: dict[str, Any] = {}
        self._window: YzWindow | None = None
        self.tool: Any = self._scene.add_transform_controls("/tool", scale=0.28, line_width=3.0, depth_test=False)

    def draw_machine(self, config: Config, machine: Machine) -> None:
        """Draw what does not move, and make the parts that do."""
        vertices, faces = unit_cylinder()
        self._window = map_window(config, machine)
        rails = rail_rods(machine)
        scene = self._scene
        # Shadows cost most of the time of a picture, where there is no graphics card.
        scene.configure_default_lights(cast_shadow=False)
        scene.add_batched_meshes_simple(
            "/rails", vertices, faces, rails.wxyz, rails.starts_m, batched_scales=rails.scales,
            batched_colors=rails.colours.astype(np.uint8), lod="off",
        )  # fmt: skip
        for body in self._nodes.pop("bodies", []):
            body.node.remove()
        bodies = self._nodes["bodies"] = draw_bodies(scene, machine, obstacles_of(config))
        count = rod_count(machine)
        none, still = np.zeros((count, 3)), np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))
        self._nodes["rods"] = scene.add_batched_meshes_simple(
            "/rods", vertices, faces, still, none, batched_scales=np.ones((count, 3)),
            batched_colors=np.zeros((count, 3), dtype=np.uint8), lod="off",
        )  # fmt: skip
        bare = [
            k for k in range(3) if not any((one.mesh.kind, one.mesh.number) == (FrameKind.CART, k) for one in bodies)
        ]
        self._nodes["carts"] = [scene.add_box(f"/cart{k + 1}", dimensions=_CART_M, visible=k in bare) for k in range(3)]
        self._nodes["tcp"] = scene.add_icosphere("/tcp", radius=0.018, color=_colour(style.VERMILLION))
        scene.add_frame("/axes", axes_length=0.25, axes_radius=0.006, position=self._corner(machine))
        for k, end in enumerate(rail_ends(machine)[:, 0]):
            scene.add_label(f"/rail{k + 1}", f"rail {k + 1}", position=end - [0.06, 0.0, 0.0], anchor="center-right")
        floor = float(min(machine.rails_m[:, 1].min(), self._window.z_least)) - 0.1
        middle = rail_ends(machine).mean(axis=(0, 1))
        scene.add_grid("/floor", 4.0, 4.0, cell_size=0.1, section_size=0.5, position=(middle[0], middle[1], floor),
                       cell_color=(225, 225, 225), section_color=(190, 190, 190), fade_distance=12.0)  # fmt: skip

    def place_camera(self, machine: Machine) -> None:
        """Look at the machine from the front, right and above, as the figures do."""
        camera = self._server.initial_camera
        camera.position, camera.look_at = camera_of(machine)

    def move_machine(self, machine: Machine, samples: PoseSamples, sides: tuple[float, ...], alarmed: bool) -> None:
        """Move the machine to a pose (n = 1); red, if something is wrong."""
        pose, q = samples.pose[0], samples.q_m[0]
        points = drawn_points(machine, pose, q)
        colours = arm_colours(sides, alarmed)
        rods = machine_rods(machine, pose[:3], points, colours, style.VERMILLION if alarmed else PLATFORM)
        node = self._nodes["rods"]
        node.batched_positions, node.batched_wxyzs = rods.starts_m, rods.wxyz
        node.batched_scales, node.batched_colors = rods.scales, rods.colours.astype(np.uint8)
        for cart, foot, colour in zip(self._nodes["carts"], points.feet_m, colours, strict=True):
            cart.position, cart.color = foot, tuple(colour.tolist())
        move_bodies(self._nodes["bodies"], pose, points, colours, alarmed)
        self._nodes["tcp"].position = pose[:3]
        for name in ("map", "loops"):
            if name in self._nodes:
                self._nodes[name].position = (pose[0], *self._nodes[name].position[1:])

    def draw_map(self, picture: MapPicture, x_m: float) -> None:
        """Draw the map of kappa on the plane of the TCP, with its curves det H = 0 in yellow."""
        window = self._window
        assert window is not None
        if "map" not in self._nodes:
            width, height = window.y_largest - window.y_least, window.z_largest - window.z_least
            middle = (x_m, window.y_least + width / 2.0, window.z_least + height / 2.0)
            self._nodes["map"] = self._scene.add_image(
                "/map", picture.image, width, height, format="png", wxyz=_FACING, position=middle, cast_shadow=False,
                receive_shadow=False,
            )  # fmt: skip
        else:
            self._nodes["map"].image = picture.image
        loops = np.insert(picture.loops_yz, 0, 0.0, axis=2)
        self._lines("loops", loops, style.YELLOW, 0.008)
        if "loops" in self._nodes:
            self._nodes["loops"].position = (x_m, 0.0, 0.0)

    def show_map(self, visible: bool) -> None:
        """Show the map, or hide it."""
        for name in ("map", "loops"):
            if name in self._nodes:
                self._nodes[name].visible = visible

    def forget_map(self) -> None:
        """Remove the map: it is that of another machine."""
        for name in ("map", "loops"):
            if name in self._nodes:
                self._nodes.pop(name).remove()

    def draw_task(self, config: Config, machine: Machine) -> None:
        """Mark start, goal and visits, and draw the boxes to avoid as far as the picture goes."""
        assert self._window is not None
        scene = self._scene
        # What is within a node goes with it.
        for node in self._nodes.pop("task", []):
            node.remove()
        nodes: list[Any] = []
        for k, mark in enumerate(task_marks(config)):
            ball = scene.add_icosphere(f"/task/{k}", 0.026, _colour(mark.colour), opacity=0.8, position=mark.place_m)
            scene.add_label(f"/task/{k}/name", mark.title, position=(0.0, 0.0, 0.14), anchor="bottom-center")
            nodes.append(ball)
        for k, box in enumerate(config.task.avoid):
            low, high = shown_box(box, machine, self._window)
            size, middle = tuple((high - low).tolist()), (low + high) / 2.0
            block = scene.add_box(f"/avoid/{k}", _AVOIDED, size, opacity=0.35, position=middle, cast_shadow=False)
            scene.add_label(f"/avoid/{k}/name", f"avoid[{k}]")
            nodes.append(block)
        self._nodes["task"] = nodes

    def draw_tracks(self, tracks: tuple[Track, ...]) -> None:
        """Draw the way of the TCP along every motion."""
        for name in _TRACK_COLOURS:
            self._lines(name.replace(" ", "-"), np.empty((0, 2, 3)), style.BLACK, 0.0)
        for track in tracks:
            way = track.samples.pose[:, :3]
            colour, width = _TRACK_COLOURS[track.name], 0.007 if track.name == REFINED else 0.004
            self._lines(track.name.replace(" ", "-"), np.stack([way[:-1], way[1:]], axis=1), colour, width)

    def _lines(self, name: str, points: FloatArray, colour: str, width_m: float) -> None:
        if name in self._nodes:
            self._nodes.pop(name).remove()
        if len(points):
            self._nodes[name] = self._scene.add_line_segments(
                f"/{name}", points.astype(np.float32), colors=_colour(colour), thickness=width_m
            )

    def _corner(self, machine: Machine) -> tuple[float, float, float]:
        assert self._window is not None
        return float(machine.travel_m[:, 0].min()) - 0.2, self._window.y_least, self._window.z_least


def camera_of(machine: Machine) -> tuple[FloatArray, FloatArray]:
    """Choose where the camera is and what it looks at, each (3,): rails fill the picture."""
    ends = rail_ends(machine).reshape(-1, 3)
    middle, size = ends.mean(axis=0), float(np.linalg.norm(np.ptp(ends, axis=0)))
    azimuth, elevation = np.deg2rad([-52.0, 22.0])
    line = [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
    seen = middle + [0.1 * size, 0.0, 0.0]
    return seen + 0.95 * size * np.array(line), seen - [0.0, 0.0, 0.03 * size]


def _colour(name: str) -> tuple[int, int, int]:
    red, green, blue = rgb(name).tolist()
    return red, green, blue
