"""Bodies given as meshes: the convex hull of a file's points, covered by few of them and a radius."""

from enum import StrEnum
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from pydantic import Field, ValidationInfo, model_validator
from pydantic_core import PydanticCustomError

from pipeline.arrays import FloatArray
from pipeline.config.section import Section, Vector
from pipeline.regular_file import read_regular_file

_MOST_BYTES = 50_000_000
_DIGITS = 9
"""Decimals of metres that points are rounded to."""
_ROUNDING_M = 1e-8
"""More than rounding and the search for distances lose."""
_HEAVY = 1e3
"""Weight of the row by which shares of points add up to one."""


class MeshUnit(StrEnum):
    """Units of meshes: their files have none."""

    METRE = "m"
    CENTIMETRE = "cm"
    MILLIMETRE = "mm"
    INCH = "in"


_SCALES_M = {MeshUnit.METRE: 1.0, MeshUnit.CENTIMETRE: 0.01, MeshUnit.MILLIMETRE: 0.001, MeshUnit.INCH: 0.0254}


class MeshConfig(Section):
    """The convex hull of a mesh: all points within a radius of some of its points.

    The file is read with the configuration that names it, from that folder; `points_m` and `radius_m` are what was made
    of it, and where they are given it is not read.
    """

    on_one_line: ClassVar[bool] = True

    file: str = Field(min_length=1, max_length=1_000, description="STL, OBJ, PLY or OFF, from the file's folder")
    unit: MeshUnit = Field(description="of the file's numbers")
    points_max: int = Field(24, ge=4, le=64, description="most points kept; what they leave out is the radius")
    points_m: tuple[Vector, ...] = Field((), max_length=64, description="the points kept; none: from the file")
    radius_m: float = Field(0.0, ge=0.0, le=20.0, description="how far the file's points are beyond the hull of these")

    @model_validator(mode="before")
    @classmethod
    def _read(cls, data: Any, info: ValidationInfo) -> Any:
        if not isinstance(data, dict) or data.get("points_m") or not isinstance(data.get("file"), str):
            return data
        if data.get("unit") not in set(MeshUnit) or not isinstance(data.get("points_max", 24), int):
            # These keys are refused by themselves.
            return data
        folder = (info.context or {}).get("folder", Path())
        points = _points(folder / data["file"]) * _SCALES_M[MeshUnit(data["unit"])]
        kept, radius = cover(points, min(max(data.get("points_max", 24), 4), 64))
        return {**data, "points_m": tuple(map(tuple, kept.tolist())), "radius_m": radius}


def _points(path: Path) -> FloatArray:
    """Read the points of a mesh, (n, 3)."""
    try:
        import trimesh
    except ImportError:
        raise _refused("needs trimesh: pip install 'gantry-tau[meshes]'") from None
    kind = path.suffix.lower().removeprefix(".")
    if kind not in ("stl", "obj", "ply", "off"):
        raise _refused("has an unknown ending; allowed are .stl, .obj, .ply and .off")
    try:
        data = read_regular_file(path, _MOST_BYTES)
    except OSError as error:
        raise _refused(f"cannot be read ({path}): {error.strerror}") from None
    try:
        mesh = trimesh.load_mesh(trimesh.util.wrap_as_stream(data), file_type=kind, process=False)
        points = np.asarray(mesh.vertices, dtype=float).reshape(-1, 3)
    except Exception as error:  # noqa: BLE001  # whatever a library raises at damaged data
        raise _refused(f"is not a mesh ({path}): {error}") from None
    if len(points) == 0 or not np.isfinite(points).all():
        raise _refused(f"has no points, or some that are no numbers ({path})")
    return np.unique(points, axis=0)


def _refused(message: str) -> PydanticCustomError:
    return PydanticCustomError("rule", "{key} {message}", {"key": "file", "message": message})


def cover(points: FloatArray, most: int) -> tuple[FloatArray, float]:
    """Keep the fewest of points (n, 3), up to `most`, whose hull is near all of them; also by how much it is not.

    The extreme points along the axes come first, then always the one that is farthest from the hull of those kept.
    """
    points = _on_the_hull(points.round(_DIGITS))
    kept = list(dict.fromkeys([*points.argmin(axis=0).tolist(), *points.argmax(axis=0).tolist()]))[:most]
    while True:
        away = np.array([_distance(point, points[kept]) for point in points])
        if len(kept) == min(most, len(points)) or away.max() <= _ROUNDING_M:
            break
        kept.append(int(away.argmax()))
    beyond = float(away.max())
    return points[kept], 0.0 if beyond <= _ROUNDING_M else round(beyond + _ROUNDING_M, _DIGITS)


def _on_the_hull(points: FloatArray) -> FloatArray:
    from scipy.spatial import ConvexHull, QhullError

    try:
        return np.asarray(points[np.sort(ConvexHull(points).vertices)], dtype=float)
    except (QhullError, ValueError):
        # Flat: all points may be corners.
        return points


def _distance(point: FloatArray, corners: FloatArray) -> float:
    """Bound the distance of a point from the hull of others from above: to a point that is certainly in it."""
    from scipy.optimize import nnls

    scale = max(float(np.abs(corners - point).max()), 1e-9)
    rows = np.vstack([(corners - point).T / scale, np.full(len(corners), _HEAVY)])
    share, _ = nnls(rows, np.append(np.zeros(3), _HEAVY))
    total = share.sum()
    nearest = share @ corners / total if total > 0.0 else corners[0]
    return float(np.linalg.norm(nearest - point))
