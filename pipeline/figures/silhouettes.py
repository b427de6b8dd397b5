"""Bodies of the machine in a parallel projection: their outlines, those farther away first."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull

from pipeline.arrays import FloatArray
from pipeline.machine.bodies.meshes import BodyMesh, mesh_frame
from pipeline.machine.drawing import DrawnPoints

AZIMUTH, ELEVATION = np.deg2rad([-58.0, 20.0])
"""Where the machine is seen from: the front, right and above."""


@dataclass(frozen=True, eq=False)
class Silhouette:
    """The outline (k, 2) of a convex body, and the body."""

    outline: FloatArray
    mesh: BodyMesh


def project(points: FloatArray) -> FloatArray:
    """Project points (..., 3) along the line of sight, to the right and upwards, in metres. Shape (..., 2)."""
    right = np.array([-np.sin(AZIMUTH), np.cos(AZIMUTH), 0.0])
    up = np.array(
        [
            -np.sin(ELEVATION) * np.cos(AZIMUTH),
            -np.sin(ELEVATION) * np.sin(AZIMUTH),
            np.cos(ELEVATION),
        ]
    )
    return np.stack([points @ right, points @ up], axis=-1)


def silhouettes(meshes: tuple[BodyMesh, ...], pose: FloatArray, points: DrawnPoints) -> list[Silhouette]:
    """Project bodies for a pose (6,) and the points drawn there, in the order in which they cover each other."""
    towards = [np.cos(ELEVATION) * np.cos(AZIMUTH), np.cos(ELEVATION) * np.sin(AZIMUTH), np.sin(ELEVATION)]
    found = []
    for mesh in meshes:
        corners = mesh_frame(mesh, pose, points).place(mesh)
        seen = project(corners)
        depth = corners @ towards
        # Thick bodies are in front of thin ones at one place.
        thick = min(np.ptp(seen, axis=0).min(), np.ptp(depth)) / 2.0
        found.append((float(depth.mean() + thick), Silhouette(seen[ConvexHull(seen).vertices], mesh)))
    return [silhouette for _, silhouette in sorted(found, key=lambda one: one[0])]
