"""How far spherical and universal joints turn: the link leaves each joint within its cone.

With the unit vector u along the link from cart to platform, the axis e of the cone and the platform's rotation R,

    -(R e) . u >= cos(half angle) at the platform,    e . u >= cos(half angle) at a cart,

each joint a limit of its own. Margins are differences of cosines: smooth at every angle, and linear in the link.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.config import Config
from pipeline.limits.interface.limit import Curve, Limit, Wording
from pipeline.limits.interface.measure import Measure
from pipeline.limits.interface.proof import CertificateEntry, CertificateKey, ProvenQuantity, Side
from pipeline.limits.interface.relaxation import RegionFilter, Relaxation, with_values
from pipeline.machine.geometry import Machine, dot, rotation, turned
from pipeline.machine.joints.cone import JointCone
from pipeline.machine.samples import PoseSamples

if TYPE_CHECKING:
    from pipeline.inclusion.proven_box import ProvenBox
    from pipeline.limits.interface.rows import Nodes, ProgramPart

JOINT_ANGLE = CertificateKey("joint_angle_deg", Side.LARGEST, None, "angle of the {}", "°", 2, optional=True)
PROOF_SLACK, _REST_SLACK, _ERROR_SLACK = 1e-6, 0.2, 0.02
"""What proven cosines are weakened by, and the shares of how far they may be from a line and of what errors take: then
other arithmetic verifies them."""
_NODE_MARGIN_DEG = 0.2
"""What nodes keep on top, for what happens between them."""
_STEP_DEG, _LARGEST_DEG = 1.0, 179.0
ALL_CONES = "every platform_cone and cart_cone of machine.links"


@dataclass(frozen=True, eq=False)
class ConeOfJoint:
    """A joint turns no farther than its cone allows.

    Attributes
    ----------
    cone : JointCone
        The joint and its cone.
    """

    cone: JointCone
    cost: int = 1
    rounding: float = 1e-9
    slack: float = 0.001
    near: float = 0.1
    least: float = 0.0
    proven_under_error: bool = True

    @property
    def key(self) -> str:
        """Configuration key of the half angle."""
        return f"{self.cone.key}.half_angle_deg"

    @property
    def wording(self) -> Wording:
        """How the limit is named in messages."""
        return Wording(
            name=self.cone.joint,
            key=self.key,
            rejected_move=f"the {self.cone.joint} leaves its cone",
            refused_points=f"turn the {self.cone.joint} beyond {self.key} ({self.cone.half_angle_deg:g})",
            broken_path=f"{self.cone.joint} beyond its cone, degrees",
            path_advice=f"Raise refine.nodes or {self.key}.",
            proof_advice=f"Raise {self.key}.",
            raise_key=self.key,
        )

    @property
    def requirement(self) -> str:
        """What it asks for, in a few words."""
        return f"{self.cone.joint} within {self.cone.half_angle_deg:g} deg of its axis"

    def margins(self, samples: PoseSamples) -> FloatArray:
        """Compute cosines of angle less that of the half angle, shape (n, 1)."""
        return np.asarray(joint_cosines(self.cone, samples) - self.cone.least_cosine)[:, None]

    def values(self, samples: PoseSamples) -> FloatArray:
        """Compute the margins, shape (n, 1)."""
        return self.margins(samples)

    def excess(self, samples: PoseSamples) -> FloatArray:
        """By how many degrees the joint is beyond its cone, shape (n, 1)."""
        return joint_angles_deg(self.cone, samples)[:, None] - self.cone.half_angle_deg

    def violations(self, samples: PoseSamples) -> list[str]:
        """State a joint beyond its cone."""
        if self.margins(samples)[0, 0] >= 0.0:
            return []
        angle = joint_angles_deg(self.cone, samples)[0]
        asked = f"{self.key} allows {self.cone.half_angle_deg:g}"
        return [f"turns the {self.cone.joint} {angle:.4g} degrees off its axis; {asked}"]

    def curves(self, samples: PoseSamples) -> Sequence[Curve]:
        """Return the angle at each sample."""
        angles = joint_angles_deg(self.cone, samples)
        return (Curve(self.cone.short_name, "deg", angles, -np.inf, self.cone.half_angle_deg),)

    def node_margin(self, clearance_margin_m: float) -> float:
        """Return what nodes keep on top: the cosine of a fifth of a degree, or half the cone if that is less."""
        half = self.cone.half_angle_deg
        return float(np.cos(np.deg2rad(half - min(_NODE_MARGIN_DEG, half / 2.0)))) - self.cone.least_cosine

    def program_part(self, nodes: "Nodes") -> "ProgramPart":
        """Write that the link of every inner node is within the cone, if any comes near its edge."""
        from pipeline.limits.program_rows.joint_cone import cone_part

        margin = self.node_margin(nodes.clearance_margin_m)
        return cone_part(self.wording.name, self.cone, self.values(nodes.guess)[:, 0], margin, nodes)

    @property
    def quantities(self) -> tuple[ProvenQuantity, ...]:
        """The angle between link and axis."""
        return (ProvenQuantity(JOINT_ANGLE, self.cone.joint, (-np.inf, self.cone.half_angle_deg)),)

    def bound(self, box: "ProvenBox") -> FloatArray:
        """Bound the angle over a proven box from above, in degrees, shape (1, 2)."""
        from pipeline.inclusion.bounds import angle_above_deg, joint_cosine

        least, rest, by_errors = joint_cosine(box, self.cone)
        slack = PROOF_SLACK + _REST_SLACK * rest + _ERROR_SLACK * by_errors
        return np.array([[-np.inf, angle_above_deg(least - slack)]])

    def unproven(self, bounds: FloatArray) -> str:
        """State that the joint is not proven to stay within its cone."""
        angle = float(bounds[0, 1])
        if angle <= self.cone.half_angle_deg:
            return ""
        most = self.cone.half_angle_deg
        return f"{self.cone.joint} is not proven to stay within {most:g} degrees of its axis (bound {angle:.6g})"


def joint_cosines(cone: JointCone, samples: PoseSamples) -> FloatArray:
    """Compute the cosines between link and axis at n poses, shape (n,)."""
    u = samples.H[:, :3, cone.link]
    if not cone.at_platform:
        return dot(u, cone.axis)
    return -dot(u, turned(rotation(*samples.pose[:, 3:].T), cone.axis))


def joint_angles_deg(cone: JointCone, samples: PoseSamples) -> FloatArray:
    """Compute the angles between link and axis at n poses, shape (n,)."""
    return np.rad2deg(np.arccos(np.clip(joint_cosines(cone, samples), -1.0, 1.0)))


def for_poses(machine: Machine, kappa_max: float) -> list[Limit]:
    """Return the limits of poses by themselves: one for each joint that has a cone."""
    return [ConeOfJoint(cone) for cone in machine.joint_cones]


def for_moves(config: Config, machine: Machine) -> list[Limit]:
    """Return the limits of moves between regions."""
    return for_poses(machine, config.route.kappa_max)


def for_path(config: Config, machine: Machine) -> list[Limit]:
    """Return the limits of a path."""
    return for_poses(machine, config.route.kappa_max)


def relaxations(config: Config, machine: Machine) -> list[Relaxation]:
    """Return wider cones of each joint, a degree apart; if several have one, the machine without any first."""
    cones = machine.joint_cones
    whole = ALL_CONES if len(cones) > 1 else ""
    found = [Relaxation.removal(whole, _without_cones(config, cones))] if whole else []
    return found + [replace(_wider(config, cone), part_of=whole) for cone in cones]


def _wider(config: Config, cone: JointCone) -> Relaxation:
    def change(value: float) -> Config:
        return _with_cone(config, cone, value)

    def prepare(samples: PoseSamples, windows_m: FloatArray) -> RegionFilter:
        cosines = joint_cosines(cone, samples)
        return lambda value: (windows_m, cosines >= replace(cone, half_angle_deg=value).least_cosine)

    first = np.floor(cone.half_angle_deg / _STEP_DEG) + 1.0
    wider = _STEP_DEG * np.arange(first, _LARGEST_DEG / _STEP_DEG + 1.0)
    return Relaxation.of_one_table(f"{cone.key}.half_angle_deg", cone.half_angle_deg, wider, change, prepare)


def _without_cones(config: Config, cones: Sequence[JointCone]) -> Config:
    for cone in cones:
        config = _with_cone(config, cone, None)
    return config


def _with_cone(config: Config, cone: JointCone, half_angle_deg: float | None) -> Config:
    """Return the configuration with another half angle of a cone, or without that cone."""
    *_, name, key = cone.key.split(".")
    link = getattr(config.machine.links, name)
    wanted = (
        None if half_angle_deg is None else getattr(link, key).model_copy(update={"half_angle_deg": half_angle_deg})
    )
    links = config.machine.links.model_copy(update={name: link.model_copy(update={key: wanted})})
    return with_values(config, "machine", links=links)


def _room_deg(samples: PoseSamples) -> float:
    """Reduce to the least angle that is left to the edge of a cone."""
    cones = samples.machine.joint_cones
    return min(float((cone.half_angle_deg - joint_angles_deg(cone, samples)).min()) for cone in cones)


CERTIFICATE = CertificateEntry((JOINT_ANGLE,))
MEASURES: tuple[Measure, ...] = (
    Measure(
        key="min_joint_room_deg",
        name="least angle to the edge of a joint's cone",
        unit="deg",
        prefers="higher",
        resolution=1e-4,
        reduce=_room_deg,
        applies=lambda machine: bool(machine.joint_cones),
    ),
)
