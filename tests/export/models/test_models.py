"""The exported machine in MuJoCo and Pinocchio: loaded as it is, assembled, moving and pushing as here."""

import re
from collections.abc import Callable
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
import yaml
from scipy.interpolate import CubicHermiteSpline

from pipeline.errors import UsageError
from pipeline.export import ExportRequest, export_files
from pipeline.export.formats import Format
from pipeline.export.models.joints import platform_angles, universal_angles
from pipeline.machine import Machine
from pipeline.machine.dynamics import inverse_dynamics
from pipeline.machine.geometry import LINKS, rotation
from pipeline.machine.kinematics import inverse_kinematics, pose_jacobian
from pipeline.retime import TrajectorySamples, sample_trajectory
from tests.certify.paths import line_path
from tests.export.models.engines import Answer, ask_mujoco, ask_pinocchio
from tests.rails import off_x
from tests.retime.proof.conftest import at_rest_at_both_ends

NAMES = ("x1", "x2", "x3", "t2", "t3")


@pytest.fixture(scope="module")
def request_(reference: TrajectorySamples, machine: Machine) -> ExportRequest:
    """The reference motion of the reference machine with a load."""
    assert machine.masses is not None
    return ExportRequest(
        reference,
        machine.acceleration_mps2,
        NAMES,
        machine=replace(machine, masses=replace(machine.masses, load_kg=4.0)),
    )


@pytest.fixture(scope="module")
def mjcf(request_: ExportRequest) -> str:
    """Its model for MuJoCo."""
    return export_files(Format.MJCF, request_)[""].decode()


@pytest.fixture(scope="module")
def urdf(request_: ExportRequest) -> dict[str, str]:
    """Its URDF, and the loops beside it."""
    return {suffix: content.decode() for suffix, content in export_files(Format.URDF, request_).items()}


@pytest.fixture(scope="module")
def joints(request_: ExportRequest) -> dict[str, np.ndarray]:
    """All joints of the tree along the motion."""
    machine, samples = request_.machine, request_.samples
    assert machine is not None
    driven = dict(zip(NAMES, samples.q_m.T, strict=True))
    return driven | universal_angles(machine, samples) | platform_angles(machine, samples)


@pytest.fixture(scope="module")
def by_mujoco(mjcf: str, reference: TrajectorySamples) -> Answer:
    """What MuJoCo says along the motion."""
    pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    return ask_mujoco(mjcf, reference.qdd_mps2)


@pytest.fixture(scope="module")
def by_pinocchio(urdf: dict[str, str], joints: dict[str, np.ndarray], reference: TrajectorySamples) -> Answer:
    """What Pinocchio says along the motion."""
    pytest.importorskip("pinocchio", reason="Pinocchio is not installed: pip install '.[consumers]'")
    return ask_pinocchio(urdf[""], urdf[".yaml"], joints, reference.qd_mps, reference.qdd_mps2)


@pytest.mark.parametrize("engine", ["by_mujoco", "by_pinocchio"])
def test_poses_and_forces_are_those_of_the_project(
    request_: ExportRequest, engine: str, request: pytest.FixtureRequest
) -> None:
    """Along the whole motion: loops closed and poses met to a nanometre, drive forces to 1e-4 N of 420."""
    answer: Answer = request.getfixturevalue(engine)
    pose = request_.samples.pose
    assert answer.gap_m < 1e-9
    assert answer.tcp_m == pytest.approx(pose[:, :3], abs=1e-9)
    assert pytest.approx(rotation(pose[:, 3], pose[:, 4], pose[:, 5]), abs=1e-9) == answer.R
    assert answer.drive_n == pytest.approx(_drive_forces(request_), abs=1e-4)


def test_both_engines_agree(by_mujoco: Answer, by_pinocchio: Answer) -> None:
    """One file each, made apart: the same poses and forces."""
    assert by_pinocchio.tcp_m == pytest.approx(by_mujoco.tcp_m, abs=1e-9)
    assert by_pinocchio.drive_n == pytest.approx(by_mujoco.drive_n, abs=1e-6)


def _drive_forces(request: ExportRequest) -> np.ndarray:
    """The project's own inverse dynamics: x'' = J q'' + J' q', J' by differences along the motion."""
    machine, samples = request.machine, request.samples
    assert machine is not None
    assert machine.masses is not None

    def jacobian(ahead_s: float, rate: np.ndarray) -> np.ndarray:
        return pose_jacobian(machine, samples.pose + ahead_s * rate, samples.q_m + ahead_s * samples.qd_mps)

    J, h = pose_jacobian(machine, samples.pose, samples.q_m), 1e-4
    rate = np.einsum("nij,nj->ni", J, samples.qd_mps)
    change = (jacobian(h, rate) - jacobian(-h, rate)) / (2.0 * h)
    acceleration = np.einsum("nij,nj->ni", J, samples.qdd_mps2) + np.einsum("nij,nj->ni", change, samples.qd_mps)
    carts, carts2 = samples.q_m[:, :3], samples.qdd_mps2[:, :3]
    return inverse_dynamics(machine, machine.masses, samples.pose, carts, rate, acceleration, carts2).drive_n


def test_mujoco_follows_the_commands_with_closed_loops(
    mjcf: str, request_: ExportRequest, recwarn: pytest.WarningsRecorder
) -> None:
    """Two seconds driven by the position actuators: no warning, loops within 0.1 um, the TCP a millimetre behind."""
    mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    model = mujoco.MjModel.from_xml_string(mjcf)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("start").id)
    samples = request_.samples
    commands = CubicHermiteSpline(samples.t_s, samples.q_m, samples.qd_mps)
    gaps, errors = [], []
    for step in range(2_000):
        data.ctrl[:] = commands((step + 1) * model.opt.timestep)
        mujoco.mj_step(model, data)
        if step % 10 == 9:
            mujoco.mj_forward(model, data)
            ends = data.site_xpos[np.stack([model.eq_obj1id, model.eq_obj2id])]
            gaps.append(np.linalg.norm(ends[0] - ends[1], axis=1).max())
            errors.append(np.linalg.norm(data.sensor("tcp_pos").data - samples.pose[(step + 1) // 10, :3]))
    assert max(gaps) < 1e-7
    assert max(errors) < 1e-3
    assert not any(warning.number for warning in data.warning)
    assert not recwarn.list


def test_sensors_say_what_they_are_called(mjcf: str, request_: ExportRequest) -> None:
    """Positions and velocities of the drives, the TCP, and along the links the forces of the project at rest."""
    mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    model = mujoco.MjModel.from_xml_string(mjcf)
    data, machine, samples = mujoco.MjData(model), request_.machine, request_.samples
    assert machine is not None
    assert machine.masses is not None
    mujoco.mj_resetDataKeyframe(model, data, model.key("row100").id)
    mujoco.mj_forward(model, data)
    for k, name in enumerate(NAMES):
        assert data.sensor(f"{name}_position").data[0] == pytest.approx(samples.q_m[100, k], abs=1e-12)
        assert data.sensor(f"{name}_velocity").data[0] == pytest.approx(samples.qd_mps[100, k], abs=1e-12)
    assert data.sensor("tcp_pos").data == pytest.approx(samples.pose[100, :3], abs=1e-12)
    step = 1e-6
    ahead = samples.pose[100, :3] + step * data.sensor("tcp_linvel").data
    J = pose_jacobian(machine, samples.pose[100:101], samples.q_m[100:101])[0]
    assert ahead == pytest.approx(samples.pose[100, :3] + step * (J @ samples.qd_mps[100])[:3], abs=1e-15)
    # At rest at the start, with drives that carry what holds the machine: what is measured at the foot of a link is its
    # force without the half of its weight that the cart carries along with it.
    mujoco.mj_resetDataKeyframe(model, data, 0)
    still = np.zeros_like(samples.pose[:1])
    held = inverse_dynamics(machine, machine.masses, samples.pose[:1], samples.q_m[:1, :3], still, still, still[:, :3])
    data.qfrc_applied[[model.joint(name).dofadr[0] for name in NAMES]] = held.drive_n[0]
    model.actuator_gainprm[:] = model.actuator_biasprm[:] = 0.0
    mujoco.mj_forward(model, data)
    for link, name in enumerate(LINKS):
        base = data.site(f"link_{name}_base")
        u, half = base.xmat.reshape(3, 3)[:, 0], machine.masses.link_kg[link] / 2.0
        expected = held.link_n[0, link] - half * machine.masses.gravity_mps2 @ u
        assert data.sensor(f"link_{name}_force").data[0] == pytest.approx(expected, abs=2e-3 * abs(expected))


def test_keys_are_named_after_what_happens(mjcf: str, reference: TrajectorySamples) -> None:
    """Start, goal and every change of the working mode are found by name, all other rows by their number."""
    names = [key.get("name", "") for key in ElementTree.fromstring(mjcf).iter("key")]
    assert len(names) == len(set(names)) == len(reference)
    assert (names[0], names[-1]) == ("start", "goal")
    changes = [name for name in names if name.startswith("mode_")]
    assert [re.sub("_row.*", "", name) for name in changes] == ["mode_LRL", "mode_RRL", "mode_RRR"]
    assert all(names.index(name) == int(name.rsplit("row", 1)[1]) for name in changes)


def test_the_integrator_steps_at_most_a_millisecond(make_samples, machine: Machine) -> None:
    """At the period of the rows or a whole part of it, with loops as stiff as two steps."""
    for period_s, step_s in ((0.0005, 0.0005), (0.001, 0.001), (0.0025, 0.0025 / 3), (0.05, 0.001)):
        request = ExportRequest(make_samples(period_s), machine.acceleration_mps2, NAMES, machine=machine)
        root = ElementTree.fromstring(export_files(Format.MJCF, request)[""])
        option, connect = root.find("option"), root.find("equality/connect")
        assert option is not None
        assert connect is not None
        assert float(option.get("timestep", "")) == pytest.approx(step_s)
        assert float(connect.get("solref", "").split()[0]) == pytest.approx(2.0 * step_s)


def test_mujoco_finds_the_loops_of_the_tree_closed(urdf: dict[str, str], joints: dict[str, np.ndarray]) -> None:
    """Another reader of URDF: at the start of the YAML file and on the way, the frames of every loop coincide."""
    mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    # MuJoCo wants some mass in every moving body, and keeps frames only when told to.
    keep = '<mujoco><compiler fusestatic="false" boundmass="1e-9" boundinertia="1e-9"/></mujoco></robot>'
    model = mujoco.MjModel.from_xml_string(urdf[""].replace("</robot>", keep))
    data = mujoco.MjData(model)
    loops = yaml.safe_load(urdf[".yaml"])
    count = len(next(iter(joints.values())))
    on_the_way = ({name: float(values[k]) for name, values in joints.items()} for k in (0, count // 2, count - 1))
    rows = [loops["start"], *on_the_way]
    assert rows[0] == pytest.approx(rows[1])
    for row in rows:
        for name, value in row.items():
            data.joint(name).qpos[0] = value
        mujoco.mj_kinematics(model, data)
        for one, two in loops["closed_loop"]:
            assert data.body(one).xpos == pytest.approx(data.body(two).xpos, abs=1e-9)


def test_a_tree_has_every_joint_once(urdf: dict[str, str], joints: dict[str, np.ndarray]) -> None:
    """Joints of the URDF are those of the bag's joint states, drives by their configured names and limits."""
    root = ElementTree.fromstring(urdf[""])
    moving = {joint.get("name"): joint for joint in root.iter("joint") if joint.get("type") != "fixed"}
    assert set(moving) == set(joints)
    limit = moving["t2"].find("limit")
    assert limit is not None
    assert [float(limit.get(key, "")) for key in ("lower", "upper", "effort", "velocity")] == [0.95, 1.25, 1000.0, 0.1]
    assert yaml.safe_load(urdf[".yaml"])["name_mot"] == list(NAMES)


@pytest.mark.parametrize("kind", ["on axis", "general"])
@pytest.mark.parametrize("seed", [1, 2])
def test_machines_of_any_geometry_close(
    draw_machine: Callable[[int, str], Machine], draw_controlled, machine: Machine, kind: str, seed: int
) -> None:
    """Random machines, at random poses in all working modes: MuJoCo finds every loop closed."""
    pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    drawn = replace(draw_machine(seed, kind), masses=machine.masses)
    solution = inverse_kinematics(drawn, *draw_controlled(seed, 100))
    q, pose = solution.q_m[solution.reachable], solution.pose[solution.reachable]
    assert len(q) > 10
    zero = np.zeros_like(q)
    samples = TrajectorySamples(0.01, 0.01 * np.arange(len(q)), q, zero, zero, pose, zero[:, 0])
    request = ExportRequest(samples, drawn.acceleration_mps2, NAMES, machine=drawn)
    answer = ask_mujoco(export_files(Format.MJCF, request)[""].decode(), zero)
    assert answer.gap_m < 1e-9
    assert answer.tcp_m == pytest.approx(pose[:, :3], abs=1e-9)


def test_what_cannot_be_a_model_is_refused(request_: ExportRequest, make_samples, machine: Machine) -> None:
    """No masses, too many keys, a link along its rail, a drive named like a passive joint: with what to change."""
    without = replace(request_, machine=replace(machine, masses=None))
    for kind in (Format.MJCF, Format.URDF):
        with pytest.raises(UsageError, match=r"needs masses.*\n.*machine.dynamics"):
            export_files(kind, without)
    with pytest.raises(UsageError, match=r"16,001 rows are too many keyframes.*\n.*--period"):
        export_files(Format.MJCF, replace(request_, samples=make_samples(0.2 / 16_000)))
    along = replace(request_.samples, pose=request_.samples.pose.copy())
    along.pose[5] = [along.q_m[5, 0] + 1.21, *machine.rails_m[0], 0.0, 0.0, 0.0]
    with pytest.raises(UsageError, match=r"at 0\.05 s link 1 lies along its rail"):
        export_files(Format.MJCF, replace(request_, samples=along))
    with pytest.raises(UsageError, match=r"platform_x is the name of a passive joint.*\n.*export.joint_names"):
        export_files(Format.URDF, replace(request_, joint_names=("platform_x", *NAMES[1:])))


def test_rails_off_x_are_those_of_mujoco(machine: Machine) -> None:
    """Another engine has the same poses and drive forces on rails that rise: along them carts feel their weight."""
    pytest.importorskip("mujoco", reason="MuJoCo is not installed")
    skewed = off_x(machine)
    samples = sample_trajectory(at_rest_at_both_ends(line_path(skewed), 1.0), 0.05)
    request = ExportRequest(samples, machine.acceleration_mps2, NAMES, machine=skewed)
    found = ask_mujoco(export_files(Format.MJCF, request)[""].decode(), samples.qdd_mps2)
    assert found.gap_m < 1e-9
    assert found.tcp_m == pytest.approx(samples.pose[:, :3], abs=1e-9)
    assert found.drive_n == pytest.approx(_drive_forces(request), abs=1e-4)
    robot = ElementTree.fromstring(export_files(Format.URDF, request)[""])
    for arm, name in enumerate(NAMES[:3]):
        axis = robot.find(f"./joint[@name='{name}']/axis")
        assert axis is not None
        np.testing.assert_array_equal([float(x) for x in axis.attrib["xyz"].split()], skewed.rail_directions[arm])
