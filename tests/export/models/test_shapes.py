"""Declared bodies in MuJoCo are where they are here."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.export import ExportRequest, export_files
from pipeline.export.formats import Format
from pipeline.machine import Machine
from pipeline.machine.bodies.meshes import body_meshes, mesh_frame
from pipeline.machine.drawing import drawn_points
from pipeline.machine.shapes.model import FrameKind
from pipeline.retime import TrajectorySamples


def test_meshes_are_where_bodies_are(reference: TrajectorySamples, ends_machine: Machine) -> None:
    """At a key, the corners of every mesh are those of its body; the end of a rod that is in its tube aside."""
    mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    rows = slice(300, 302)
    names = ("t_s", "q_m", "qd_mps", "qdd_mps2", "pose", "kappa")
    samples = replace(reference, **{name: getattr(reference, name)[rows] for name in names})
    names = ("x1", "x2", "x3", "t2", "t3")
    request = ExportRequest(samples, ends_machine.acceleration_mps2, names, machine=ends_machine)
    model = mujoco.MjModel.from_xml_string(export_files(Format.MJCF, request)[""].decode())
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    pose, points = samples.pose[0], drawn_points(ends_machine, samples.pose[0], samples.q_m[0])
    assert model.ngeom == len(body_meshes(ends_machine))
    for mesh in body_meshes(ends_machine):
        geom = model.geom(f"body_{mesh.name.replace(' ', '_')}")
        first, count = model.mesh_vertadr[geom.dataid[0]], model.mesh_vertnum[geom.dataid[0]]
        placed = data.geom_xpos[geom.id] + model.mesh_vert[first : first + count] @ (
            data.geom_xmat[geom.id].reshape(3, 3).T
        )
        expected = mesh_frame(mesh, pose, points).place(mesh)
        if mesh.name.startswith("rod"):
            placed, expected = placed[mesh.shares > 0.0], expected[mesh.shares > 0.0]
        # Links are round: how they are turned about their axis differs.
        np.testing.assert_allclose(placed.mean(axis=0), expected.mean(axis=0), atol=1e-5)
        if mesh.kind != FrameKind.LINK:
            gaps = np.linalg.norm(placed[:, None] - expected, axis=2)
            assert gaps.min(axis=1).max() < 1e-5
            assert gaps.min(axis=0).max() < 1e-5
