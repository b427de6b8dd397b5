"""Frames, rails, platform and links: the machine as arrays, and where its joints are at a pose.

Link order everywhere: 1, 2a, 2b, 3a, 3b, 3c. Actuator order: q = (c1, c2, c3, l2b, l3b).
A pose is (x, y, z, rx, ry, rz) with R = Rx(rx) Rz(rz) Ry(ry); the controlled pose leaves out ry, which
follows from the triangle. Working modes are numbered 0 (LLL) to 7 (RRR), arm 1 the highest bit.

Arrays of many vectors or matrices are stored coordinate by coordinate, whatever their axes say: what is done to one
coordinate of them all then runs through memory in order, several times as fast.
"""

from dataclasses import dataclass, field

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.config import FixedLinkConfig, MachineConfig, TelescopeConfig, TriangleLinkConfig
from pipeline.config.machine.limits import push_and_pull
from pipeline.machine.joints.cone import JointCone, build_joint_cones
from pipeline.machine.masses import Masses, build_masses
from pipeline.machine.shapes.build import build_bodies
from pipeline.machine.shapes.model import Bodies
from pipeline.machine.shapes.obstacles import build_obstacles

LINKS = ("1", "2a", "2b", "3a", "3b", "3c")
ARM_OF_LINK = np.array([0, 1, 1, 2, 2, 2])
PRIMARY = np.array([0, 1, 3])
"""The link of each arm that decides its working mode: 1, 2a, 3a."""
TELESCOPES = np.array([2, 4])
TRIANGLE = 5
ACTUATORS = ("c1", "c2", "c3", "l2b", "l3b")
MODES = tuple(a + b + c for a in "LR" for b in "LR" for c in "LR")
MODE_SIGNS = np.array([[-1.0 if letter == "L" else 1.0 for letter in mode] for mode in MODES])
"""Per mode and arm: where the cart is, seen from the platform joint, -1 (L) or +1 (R). Shape (8, 3)."""


@dataclass(frozen=True, eq=False)
class Machine:
    """A 5-DOF Gantry-Tau as arrays; lengths in metres, one row per rail, link or actuator.

    Attributes
    ----------
    rails_m : (3, 2)
        y and z of each rail where x is 0.
    travel_m : (3, 2)
        Least and largest cart position along the rail.
    platform_points_m, cart_offsets_m : (6, 3)
        Joints of each link, in the platform frame and from the cart's origin.
    lengths_m : (6,)
        Link lengths; NaN for the telescopes.
    strokes_m : (2, 2)
        Least and largest length of telescopes 2b and 3b.
    triangle_sign : float
        Sign of y_platform . (R w x u_3c) in the assembled machine.
    rail_directions : (3, 3)
        Unit vectors d_k along the rails: cart k is at (0, y, z) + q_k d_k. They are e_x on parallel rails.
    characteristic_length_m : float
        What moments are divided by in the statics matrix.
    link_link_m, link_rail_m : float
        Least distance between axes; NaN where it is not checked.
    shared_joint_m : float
        How far apart the joints of two links may be that count as one.
    velocity_mps, acceleration_mps2, jerk_mps3 : (5,)
        Limits of the actuators; infinite where there is none.
    force_n : (2, 5)
        Largest push and pull of the drives, infinite where there is none; (5,) if they are the same.
    link_force_n : (2,)
        Largest push and pull along a link, likewise.
    tcp_speed_mps, tcp_acceleration_mps2 : float
        Limits of the tool centre point; infinite where there is none.
    holding_fraction : float
        Part of the force limits that holding the machine against gravity may take.
    gravity_stiffness_npm : float
        Least stiffness by gravity that the drives have to deal with, -inf where it is not limited.
    joint_cones : tuple of JointCone
        How far joints may turn; none where it is not limited.
    masses : Masses or None
        What forces follow from; None where the configuration gives no masses.
    bodies : Bodies or None
        What is kept apart beside axes; None where the configuration gives no bodies.
    obstacles : Bodies or None
        The pairs of what moves and bodies fixed to the frame, whose distances depend on x; None where there are none.
    """

    rails_m: FloatArray
    travel_m: FloatArray
    platform_points_m: FloatArray
    cart_offsets_m: FloatArray
    lengths_m: FloatArray
    strokes_m: FloatArray
    triangle_sign: float
    link_link_m: float
    link_rail_m: float
    velocity_mps: FloatArray
    acceleration_mps2: FloatArray
    rail_directions: FloatArray = field(default_factory=lambda: np.tile([1.0, 0.0, 0.0], (3, 1)))
    characteristic_length_m: float = 1.0
    shared_joint_m: float = 0.0
    jerk_mps3: FloatArray = field(default_factory=lambda: np.full(5, np.inf))
    force_n: FloatArray = field(default_factory=lambda: np.full((2, 5), np.inf))
    link_force_n: FloatArray | float = np.inf
    tcp_speed_mps: float = np.inf
    tcp_acceleration_mps2: float = np.inf
    holding_fraction: float = 1.0
    gravity_stiffness_npm: float = -np.inf
    joint_cones: tuple[JointCone, ...] = ()
    masses: Masses | None = None
    bodies: Bodies | None = None
    obstacles: Bodies | None = None

    @property
    def known_masses(self) -> Masses:
        """The masses, for what needs them.

        Raises
        ------
        ValueError
            For a machine without masses.
        """
        if self.masses is None:
            raise ValueError("without masses there are no forces")
        return self.masses

    @property
    def has_parallel_rails(self) -> bool:
        """Whether all rails are exactly along X: x then enters through the carts alone."""
        return not self.rail_directions[:, 1:].any()

    @property
    def actuator_limits_m(self) -> FloatArray:
        """Least and largest value of each actuator, shape (5, 2)."""
        return np.vstack([self.travel_m, self.strokes_m])

    @property
    def force_limits_n(self) -> FloatArray:
        """Largest push (positive force) and pull of the five drives and along the six links, shape (2, 11).

        A cart is pushed along its rail, towards +X; a telescope or link that pushes is compressed.
        """
        links = np.reshape(self.link_force_n, (-1, 1))
        return np.hstack([np.broadcast_to(self.force_n, (2, 5)), np.broadcast_to(links, (2, len(LINKS)))])


def build_machine(config: MachineConfig) -> Machine:
    """Turn the machine's configuration into arrays; without a length 3c makes the triangle right-angled."""
    links = (
        config.links.l1,
        config.links.l2a,
        config.links.l2b,
        config.links.l3a,
        config.links.l3b,
        config.links.l3c,
    )
    limits = config.limits.of_actuators()
    return Machine(
        rails_m=np.array([(rail.y_m, rail.z_m) for rail in config.rails]),
        rail_directions=_directions(config),
        travel_m=np.array([rail.travel_m for rail in config.rails]),
        platform_points_m=np.array([link.platform_point_m for link in links]),
        cart_offsets_m=np.array([link.cart_offset_m for link in links]),
        lengths_m=np.array([_length(link, config) for link in links]),
        strokes_m=np.array([config.links.l2b.stroke_m, config.links.l3b.stroke_m]),
        triangle_sign=-1.0 if config.triangle_branch == "negative" else 1.0,
        link_link_m=_given(config.clearance.link_link_m, np.nan),
        link_rail_m=_given(config.clearance.link_rail_m, np.nan),
        shared_joint_m=config.clearance.shared_joint_m,
        velocity_mps=np.array([limit.velocity_mps for limit in limits]),
        characteristic_length_m=config.characteristic_length_m,
        acceleration_mps2=np.array([limit.acceleration_mps2 for limit in limits]),
        jerk_mps3=np.array([_given(limit.jerk_mps3) for limit in limits]),
        force_n=np.array([push_and_pull(limit.force_n) for limit in limits]).T,
        link_force_n=np.array(push_and_pull(config.limits.link_force_n)),
        tcp_speed_mps=_given(config.limits.tcp.speed_mps),
        tcp_acceleration_mps2=_given(config.limits.tcp.acceleration_mps2),
        joint_cones=build_joint_cones(config.links),
        holding_fraction=config.limits.holding_fraction,
        gravity_stiffness_npm=_given(config.limits.gravity_stiffness_npm, -np.inf),
        masses=None if config.dynamics is None else build_masses(config.dynamics),
        bodies=build_bodies(config),
        obstacles=build_obstacles(config, ()),
    )


def _directions(config: MachineConfig) -> FloatArray:
    """Return unit vectors (1, dy/dx, dz/dx) / |.| along the rails, shape (3, 3)."""
    along = np.array([(1.0, *rail.slopes) for rail in config.rails])
    directions: FloatArray = along / np.linalg.norm(along, axis=1, keepdims=True)
    return directions


def _given(limit: float | None, without: float = np.inf) -> float:
    return without if limit is None else limit


def _length(link: FixedLinkConfig | TelescopeConfig | TriangleLinkConfig, config: MachineConfig) -> float:
    if isinstance(link, TelescopeConfig):
        return np.nan
    if link.length_m is not None:
        return link.length_m
    side = np.subtract(link.platform_point_m, config.links.l3a.platform_point_m)
    return float(np.hypot(config.links.l3a.length_m, np.linalg.norm(side)))


def rotation_x(angle: FloatArray) -> FloatArray:
    """Rotation about x, shape (..., 3, 3)."""
    return _plane_rotation(angle, 1, 2)


def rotation_z(angle: FloatArray) -> FloatArray:
    """Rotation about z, shape (..., 3, 3)."""
    return _plane_rotation(angle, 0, 1)


def _plane_rotation(angle: FloatArray, first: int, second: int) -> FloatArray:
    angle = np.asarray(angle, dtype=float)
    matrix = np.broadcast_to(np.eye(3), (*angle.shape, 3, 3)).copy()
    cosine, sine = np.cos(angle), np.sin(angle)
    matrix[..., first, first] = matrix[..., second, second] = cosine
    matrix[..., first, second] = -sine
    matrix[..., second, first] = sine
    return matrix


def rotation(rx: FloatArray, ry: FloatArray, rz: FloatArray) -> FloatArray:
    """R = Rx(rx) Rz(rz) Ry(ry): about y first, then z, then x (the paper, section 4). Shape (..., 3, 3)."""
    cx, sx, cy, sy, cz, sz = np.cos(rx), np.sin(rx), np.cos(ry), np.sin(ry), np.cos(rz), np.sin(rz)
    rows = [
        [cz * cy, -sz, cz * sy],
        [cx * sz * cy + sx * sy, cx * cz, cx * sz * sy - sx * cy],
        [sx * sz * cy - cx * sy, sx * cz, sx * sz * sy + cx * cy],
    ]
    R = np.empty((3, 3, *np.broadcast_shapes(np.shape(rx), np.shape(ry), np.shape(rz))))
    for i, row in enumerate(rows):
        for j, entry in enumerate(row):
            R[i, j] = entry
    return np.moveaxis(R, (0, 1), (-2, -1))


def platform_arms(machine: Machine, pose: FloatArray) -> FloatArray:
    """A'_l = R a_l, the arms from the TCP to the platform joints, for poses (..., 6). Shape (..., 6, 3)."""
    R = np.moveaxis(rotation(pose[..., 3], pose[..., 4], pose[..., 5]), (-2, -1), (0, 1))
    arms = np.zeros((3, 6, *pose.shape[:-1]))
    for column, coordinates in zip(R.swapaxes(0, 1), _last(machine.platform_points_m.T, arms), strict=True):
        arms += column[:, None] * coordinates
    return np.moveaxis(arms, (0, 1), (-1, -2))


def cart_joints(machine: Machine, carts_m: FloatArray) -> FloatArray:
    """C_l = (0, rail_y, rail_z) + c_k d_k + b_l for cart positions (..., 3). Shape (..., 6, 3)."""
    joints = np.empty((3, 6, *carts_m.shape[:-1]))
    joints[:] = _last(machine.cart_offsets_m.T, joints)
    carts = np.moveaxis(carts_m, -1, 0)[ARM_OF_LINK]
    if machine.has_parallel_rails:
        joints[0] += carts
    else:
        joints += carts * _last(machine.rail_directions[ARM_OF_LINK].T, joints)
    joints[1:] += _last(machine.rails_m[ARM_OF_LINK].T, joints)
    return np.moveaxis(joints, (0, 1), (-1, -2))


def link_vectors(machine: Machine, pose: FloatArray, carts_m: FloatArray) -> FloatArray:
    """A_l - C_l for poses (..., 6) and cart positions (..., 3). Shape (..., 6, 3)."""
    vectors = platform_arms(machine, pose)
    vectors -= cart_joints(machine, carts_m)
    vectors += pose[..., None, :3]
    return vectors


def _last(constants: FloatArray, array: FloatArray) -> FloatArray:
    """Give a table of constants the trailing axes it needs to meet an array stored coordinate by coordinate."""
    return constants.reshape(*constants.shape, *[1] * (array.ndim - 2))


def turned(R: FloatArray, vector: FloatArray) -> FloatArray:
    """R v for rotations (n, 3, 3) and one vector (3,). Shape (n, 3)."""
    return np.stack([dot(R[:, i], vector) for i in range(3)]).T


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Vector products a x b of vectors (..., 3), stored like `a`."""
    product = np.empty_like(a)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        product[..., i] = a[..., j] * b[..., k] - a[..., k] * b[..., j]
    return product


def dot(a: FloatArray, b: FloatArray) -> FloatArray:
    """Scalar products a . b of vectors (..., 3); one of them may be a single vector (3,). Shape (...)."""
    product: FloatArray = a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2]
    return product


def link_lengths(machine: Machine, telescopes_m: FloatArray) -> FloatArray:
    """Lengths of the six links for telescope lengths (..., 2). Shape (..., 6)."""
    lengths = np.broadcast_to(machine.lengths_m, (*telescopes_m.shape[:-1], 6)).copy()
    lengths[..., TELESCOPES] = telescopes_m
    return lengths
