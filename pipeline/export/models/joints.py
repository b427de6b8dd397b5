"""The joints of the machine as a tree: carts on rails, links on universal joints, telescopes, the platform on link 1.

A link turns about its rail first (`link_1_u1`), then about the axis that is square to rail and link (`link_1_u2`): with
angles a and b it points along u = Rx(a) Rz(b) e_x = (cos b, sin b cos a, sin b sin a). b is between 0 and pi, and pi/2
where the working mode changes; the joint locks only where the link lies along its rail. The platform hangs on the tip
of link 1 by three hinges about z, y and x: R_link' R = Rz Ry Rx.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.errors import UsageError
from pipeline.machine.actuator_space import actuator_rates
from pipeline.machine.geometry import LINKS, Machine, dot, link_vectors, rotation
from pipeline.retime.result import TrajectorySamples

CARRIER = 0
"""The link that the platform hangs on in a tree: link 1."""
PLATFORM_JOINTS = ("platform_z", "platform_y", "platform_x")
_LEAST_SINE = 1e-3
"""Sine of the angle by which links have to be off the rail's direction, and hinges of the platform off their lock."""


def universal_joints(link: int) -> tuple[str, str]:
    """Name the two hinges of a link's joint on its cart, the one about the rail first."""
    return f"link_{LINKS[link]}_u1", f"link_{LINKS[link]}_u2"


PASSIVE_JOINTS = frozenset(
    {"platform", *PLATFORM_JOINTS, *(name for link in range(len(LINKS)) for name in universal_joints(link))}
)
"""Names of all joints of the models that are not driven."""


def universal_angles(machine: Machine, samples: TrajectorySamples) -> dict[str, FloatArray]:
    """Compute the angles (n,) of all universal joints, without jumps by whole turns, by their names.

    Raises
    ------
    UsageError
        When a link lies along its rail.
    """
    u = _directions(machine, samples.pose, samples.q_m)
    across = np.hypot(u[..., 1], u[..., 2])
    _require_unlocked(across, samples, [f"link {name} lies along its rail" for name in LINKS])
    about, square = np.unwrap(np.arctan2(u[..., 2], u[..., 1]), axis=0), np.arctan2(across, u[..., 0])
    return {
        name: angle[:, link]
        for link in range(len(LINKS))
        for name, angle in zip(universal_joints(link), (about, square), strict=True)
    }


def platform_angles(machine: Machine, samples: TrajectorySamples) -> dict[str, FloatArray]:
    """Compute the angles (n,) of the three hinges between link 1 and the platform, by their names.

    Raises
    ------
    UsageError
        When the platform's x axis is along the z axis of link 1, where two of the hinges are one.
    """
    u = _directions(machine, samples.pose, samples.q_m)[:, CARRIER]
    sine = np.hypot(u[:, 1], u[:, 2])
    y, z = u[:, 1] / sine, u[:, 2] / sine
    link = np.stack(
        [
            u,
            np.stack([-sine, u[:, 0] * y, u[:, 0] * z], axis=1),
            np.stack([np.zeros_like(y), -z, y], axis=1),
        ],
        axis=2,
    )
    turned = np.swapaxes(link, 1, 2) @ rotation(samples.pose[:, 3], samples.pose[:, 4], samples.pose[:, 5])
    across = np.hypot(turned[:, 0, 0], turned[:, 1, 0])
    _require_unlocked(across[:, None], samples, ["the platform's hinges on link 1 lock"])
    about_z, about_x = np.arctan2(turned[:, 1, 0], turned[:, 0, 0]), np.arctan2(turned[:, 2, 1], turned[:, 2, 2])
    angles = (np.unwrap(about_z), np.arctan2(-turned[:, 2, 0], across), np.unwrap(about_x))
    return dict(zip(PLATFORM_JOINTS, angles, strict=True))


@dataclass(frozen=True, eq=False)
class Rates:
    """How all that is not driven moves.

    Attributes
    ----------
    universal : dict of str to (n,)
        Rates of the universal joints by name.
    tcp_mps : (n, 3)
        Velocity of the TCP.
    omega_radps : (n, 3)
        Angular velocity of the platform in its own frame.
    """

    universal: dict[str, FloatArray]
    tcp_mps: FloatArray
    omega_radps: FloatArray


def passive_rates(machine: Machine, samples: TrajectorySamples) -> Rates:
    """Compute the rates of the platform and of the universal joints from those of the actuators.

    With v the velocity of a link's tip against its joint and L its length, u' = (v - u (u . v)) / L, b' = -u_x' / sin b
    and a' = (u_y u_z' - u_z u_y') / sin^2 b.
    """
    rates = actuator_rates(machine, samples.pose, samples.q_m[:, :3])
    twist, v = (
        np.einsum("nij,nj->ni", rates.twist, samples.qd_mps),
        np.einsum("nlij,nj->nli", rates.tips, samples.qd_mps),
    )
    u = rates.directions
    du = (v - u * dot(u, v)[..., None]) / rates.lengths_m[..., None]
    across = np.hypot(u[..., 1], u[..., 2])
    about, square = (u[..., 1] * du[..., 2] - u[..., 2] * du[..., 1]) / across**2, -du[..., 0] / across
    universal = {
        name: rate[:, link]
        for link in range(len(LINKS))
        for name, rate in zip(universal_joints(link), (about, square), strict=True)
    }
    return Rates(universal, twist[:, :3], np.einsum("nji,nj->ni", rates.rotation, twist[:, 3:]))


def _directions(machine: Machine, pose: FloatArray, q_m: FloatArray) -> FloatArray:
    vectors = link_vectors(machine, pose, q_m[:, :3])
    return vectors / np.sqrt(dot(vectors, vectors))[..., None]


def _require_unlocked(sines: FloatArray, samples: TrajectorySamples, what: Sequence[str]) -> None:
    row, column = divmod(int(np.argmin(sines)), sines.shape[1])
    if not sines[row, column] >= _LEAST_SINE:
        raise UsageError(
            f"at {samples.t_s[row]:g} s {what[column]}: a model with hinges cannot move there.\n"
            "  What to change: nothing in the export; another format has no hinges: csv, ros2, pvt."
        )
