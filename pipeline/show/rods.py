"""The machine as straight rods and blocks, in the colours of the figures."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.colors import to_rgb

from pipeline.arrays import FloatArray, IntArray
from pipeline.figures import style
from pipeline.machine.bodies.meshes import body_hulls
from pipeline.machine.drawing import DrawnPoints, platform_bars, rail_ends
from pipeline.machine.geometry import ARM_OF_LINK, TELESCOPES, Machine
from pipeline.machine.shapes.model import FrameKind

_FIXED = np.setdiff1d(np.arange(6), TELESCOPES)
PLATFORM = "#5A5A5A"
_LINK_M, _TUBE_M, _ROD_M, _BEAM_M, _RAIL_M, _BAR_M = 0.012, 0.018, 0.010, 0.014, 0.016, 0.012
"""Radii."""
_TUBE_PART = 0.62
"""Length of a telescope's tube, as a part of its least length."""


@dataclass(frozen=True, eq=False)
class Rods:
    """Cylinders from `starts_m` to `ends_m` (n, 3) with `radii_m` (n,) and colours (n, 3), 0 to 255."""

    starts_m: FloatArray
    ends_m: FloatArray
    radii_m: FloatArray
    colours: IntArray

    @property
    def lengths_m(self) -> FloatArray:
        """Length of each, shape (n,)."""
        return np.asarray(np.linalg.norm(self.ends_m - self.starts_m, axis=1))

    @property
    def scales(self) -> FloatArray:
        """What a cylinder of radius and length one along z is stretched by, shape (n, 3)."""
        return np.column_stack([self.radii_m, self.radii_m, self.lengths_m])

    @property
    def wxyz(self) -> FloatArray:
        """Quaternions that turn z into the direction of each, shape (n, 4): half way between the two."""
        direction = (self.ends_m - self.starts_m) / np.maximum(self.lengths_m, 1e-12)[:, None]
        x, y, z = direction.T
        zero = np.zeros_like(z)
        # Downwards after half a turn about x, as half way between opposite directions is nowhere.
        upwards = np.column_stack([1.0 + z, -y, x, zero])
        turned = np.where(z[:, None] < 0.0, np.column_stack([-y, 1.0 - z, zero, x]), upwards)
        return np.asarray(turned / np.linalg.norm(turned, axis=1, keepdims=True))


def rail_rods(machine: Machine) -> Rods:
    """Build the rails."""
    ends = rail_ends(machine)
    return Rods(ends[:, 0], ends[:, 1], np.full(3, _RAIL_M), np.tile(rgb(style.GREY), (3, 1)))


def machine_rods(machine: Machine, tcp_m: FloatArray, points: DrawnPoints, colours: IntArray, platform: str) -> Rods:
    """Build beams from the carts to their joints, and links and bars of the platform, unless bodies are declared.

    Parameters
    ----------
    tcp_m : (3,)
        The TCP.
    points : DrawnPoints
        A single pose.
    colours : (3, 3)
        Colour of each arm.
    platform : str
        That of the platform.
    """
    hulls = body_hulls(machine)
    kinds = {hull.kind for hull in hulls}
    corners = np.vstack([tcp_m, points.platform_joints_m])
    bars = platform_bars(machine)
    parts = [(points.feet_m[ARM_OF_LINK], points.cart_joints_m, _BEAM_M, np.tile(rgb("#404040"), (6, 1)))]
    if not any(hull.is_link for hull in hulls):
        parts = [*_link_rods(machine, points, colours), *parts]
    if FrameKind.PLATFORM not in kinds:
        parts.append((corners[bars[:, 0]], corners[bars[:, 1]], _BAR_M, np.tile(rgb(platform), (len(bars), 1))))
    starts, ends, radii, shades = zip(*parts, strict=True)
    lengths = [len(start) for start in starts]
    return Rods(np.concatenate(starts), np.concatenate(ends), np.repeat(radii, lengths), np.concatenate(shades))


def rod_count(machine: Machine) -> int:
    """Count what `machine_rods` builds."""
    hulls = body_hulls(machine)
    kinds = {hull.kind for hull in hulls}
    links = 0 if any(hull.is_link for hull in hulls) else 6 + len(TELESCOPES)
    bars = 0 if FrameKind.PLATFORM in kinds else len(platform_bars(machine))
    return len(ARM_OF_LINK) + links + bars


def _link_rods(machine: Machine, points: DrawnPoints, colours: IntArray) -> list[tuple[Any, ...]]:
    """Give fixed links, and tubes and rods of the telescopes: starts, ends, radius, colours."""
    carts, platform = points.cart_joints_m, points.platform_joints_m
    of_link = colours[ARM_OF_LINK]
    along = platform[TELESCOPES] - carts[TELESCOPES]
    share = _TUBE_PART * machine.strokes_m[:, :1] / np.linalg.norm(along, axis=1, keepdims=True)
    tubes = carts[TELESCOPES] + np.minimum(share, 1.0) * along
    return [
        (carts[_FIXED], platform[_FIXED], _LINK_M, of_link[_FIXED]),
        (carts[TELESCOPES], tubes, _TUBE_M, tube_shade(of_link[TELESCOPES])),
        (tubes, platform[TELESCOPES], _ROD_M, rod_shade(of_link[TELESCOPES])),
    ]


def tube_shade(colours: IntArray) -> IntArray:
    """Darken the colours (..., 3) of arms for the tubes of telescopes."""
    return colours * 7 // 10


def rod_shade(colours: IntArray) -> IntArray:
    """Brighten the colours (..., 3) of arms for the rods of telescopes."""
    return (colours + 255) // 2


def arm_colours(sides: tuple[float, ...], alarmed: bool) -> IntArray:
    """Give the colour of each arm: blue on the left, orange on the right, red if something is wrong. Shape (3, 3)."""
    names = [style.VERMILLION if alarmed else style.BLUE if side < 0.0 else style.ORANGE for side in sides]
    return np.array([rgb(name) for name in names])


def rgb(colour: str) -> IntArray:
    """Read a colour as red, green and blue from 0 to 255, shape (3,)."""
    return np.rint(255.0 * np.array(to_rgb(colour))).astype(np.int64)


def unit_cylinder(segments: int = 20) -> tuple[FloatArray, IntArray]:
    """Build a closed cylinder of radius and length one along z from the origin: vertices (n, 3), faces (m, 3)."""
    angle = 2.0 * np.pi * np.arange(segments) / segments
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    # Caps have corners of their own, so that their edges are sharp.
    levels = [np.column_stack([ring, np.full(segments, z)]) for z in (0.0, 1.0, 0.0, 1.0)]
    vertices = np.vstack([*levels, [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]]])
    here = np.arange(segments)
    there = (here + 1) % segments
    low, high, bottom, top = here, here + segments, 4 * segments, 4 * segments + 1
    faces = [
        np.column_stack([low, there, there + segments]),
        np.column_stack([low, there + segments, high]),
        np.column_stack([np.full(segments, bottom), there + 2 * segments, here + 2 * segments]),
        np.column_stack([np.full(segments, top), here + 3 * segments, there + 3 * segments]),
    ]
    return vertices, np.concatenate(faces)
