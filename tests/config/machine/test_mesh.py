"""Bodies given as meshes: their points in metres, few of them, and what is wrong with a file."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from pipeline.config.file import dump_config, load_config, parse_config
from pipeline.config.machine.mesh import cover
from pipeline.errors import ConfigError
from pipeline.machine import build_machine
from pipeline.machine.shapes.gjk import hull_separation
from tests.conftest import CONFIGS

trimesh = pytest.importorskip("trimesh")


def written(folder: Path, **mesh: Any) -> Path:
    """Write a configuration with a mesh on its platform."""
    data = yaml.safe_load((CONFIGS / "quick.yaml").read_text())
    data["machine"]["bodies"] = [{"name": "part", "attached_to": "platform", "mesh": mesh}]
    path = folder / "with-mesh.yaml"
    path.write_text(yaml.safe_dump(data))
    return path


def farthest(points: np.ndarray, corners: np.ndarray) -> float:
    """Measure how far points are from the hull of others."""
    hulls = np.repeat(corners[..., None], len(points), axis=2)
    return float(hull_separation(np.ascontiguousarray(points.T[None]), hulls).distance_m.max())


def test_a_mesh_is_read_from_beside_the_configuration(tmp_path: Path) -> None:
    """A box of 100 by 60 by 20 mm: its corners, without a radius; the resolved configuration needs no file."""
    (tmp_path / "parts").mkdir()
    trimesh.creation.box((100.0, 60.0, 20.0)).export(tmp_path / "parts" / "box.stl")
    config = load_config(written(tmp_path, file="parts/box.stl", unit="mm"))
    mesh = config.machine.bodies[0].mesh
    assert mesh is not None
    assert sorted(mesh.points_m) == sorted(
        (x, y, z) for x in (-0.05, 0.05) for y in (-0.03, 0.03) for z in (-0.01, 0.01)
    )
    assert mesh.radius_m == 0.0
    (tmp_path / "parts" / "box.stl").unlink()
    assert parse_config(yaml.safe_load(dump_config(config))) == config
    bodies = build_machine(config.machine).bodies
    assert bodies is not None
    assert bodies.hulls[0].points_m.shape == (8, 3)


@pytest.mark.parametrize(("unit", "scale"), [("m", 1.0), ("cm", 0.01), ("in", 0.0254)])
def test_units_are_metres_then(tmp_path: Path, unit: str, scale: float) -> None:
    """Numbers of a file have none."""
    trimesh.creation.box((2.0, 2.0, 2.0)).export(tmp_path / "box.obj")
    mesh = load_config(written(tmp_path, file="box.obj", unit=unit)).machine.bodies[0].mesh
    assert mesh is not None
    assert np.abs(mesh.points_m).max() == pytest.approx(scale)


def test_few_points_and_a_radius_cover_a_round_mesh(tmp_path: Path) -> None:
    """More points, and the radius is smaller; every point of the mesh is covered."""
    part = trimesh.creation.icosphere(subdivisions=2, radius=30.0)
    part.export(tmp_path / "ball.stl")
    radii = []
    for most in (8, 16, 32):
        mesh = load_config(written(tmp_path, file="ball.stl", unit="mm", points_max=most)).machine.bodies[0].mesh
        assert mesh is not None
        assert len(mesh.points_m) == most
        assert farthest(np.asarray(part.vertices) * 0.001, np.array(mesh.points_m)) <= mesh.radius_m
        radii.append(mesh.radius_m)
    assert radii == sorted(radii, reverse=True)
    assert radii[-1] < 0.006


def test_flat_points_are_covered() -> None:
    """A sheet has no hull of its own."""
    sheet = np.array([[x, y, 0.0] for x in range(4) for y in range(3)], dtype=float)
    kept, radius = cover(sheet, 8)
    assert farthest(sheet, kept) <= radius + 1e-9
    assert radius < 1e-6


@pytest.mark.parametrize(
    ("mesh", "expected"),
    [
        ({"file": "none.stl", "unit": "mm"}, "mesh.file cannot be read"),
        ({"file": "part.step", "unit": "mm"}, "mesh.file has an unknown ending; allowed are .stl, .obj, .ply and .off"),
        ({"file": "bad.stl", "unit": "mm"}, "mesh.file has no points"),
        ({"file": "part.stl"}, "mesh.unit: is missing; allowed is m or cm or mm or in"),
        ({"file": "part.stl", "unit": "ft"}, 'mesh.unit: is "ft"; allowed is m or cm or mm or in'),
    ],
)
def test_what_is_wrong_with_a_mesh_is_said(tmp_path: Path, mesh: dict[str, str], expected: str) -> None:
    """With the key and, of a file, its place."""
    (tmp_path / "bad.stl").write_text("solid nothing")
    with pytest.raises(ConfigError) as error:
        load_config(written(tmp_path, **mesh))
    assert expected in str(error.value).replace("mesh.file: ", "mesh.file ")
