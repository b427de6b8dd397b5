"""Cones of spherical and universal joints: how far a link may turn from the middle of its joint."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.config import LinksConfig


@dataclass(frozen=True, eq=False)
class JointCone:
    """A link leaves its joint within a cone.

    With u the unit vector along the link from cart to platform, the link leaves its platform joint along -u and its
    cart joint along u. The axis e of the cone moves with what the joint sits on: the joint keeps

        -(R e) . u >= cos(half angle) at the platform,    e . u >= cos(half angle) at a cart.

    Attributes
    ----------
    link : int
        Index of the link.
    at_platform : bool
        Whether the joint is at the platform, or at the cart.
    axis : (3,)
        e, in the platform's or the cart's frame, of length one.
    half_angle_deg : float
        Largest angle between link and axis.
    key : str
        Configuration key of the cone.
    """

    link: int
    at_platform: bool
    axis: FloatArray
    half_angle_deg: float
    key: str

    @property
    def joint(self) -> str:
        """The joint in words: "platform joint of link 2a"."""
        return f"{self._end} joint of link {self._link}"

    @property
    def short_name(self) -> str:
        """The joint where there is little room: "2a platform joint"."""
        return f"{self._link} {self._end} joint"

    @property
    def least_cosine(self) -> float:
        """Cosine of the half angle."""
        return float(np.cos(np.deg2rad(self.half_angle_deg)))

    @property
    def _end(self) -> str:
        return "platform" if self.at_platform else "cart"

    @property
    def _link(self) -> str:
        return self.key.split(".")[-2].removeprefix("l")


def build_joint_cones(links: LinksConfig) -> tuple[JointCone, ...]:
    """List the cones of all joints that have one, link by link."""
    return tuple(_cones(links))


def _cones(links: LinksConfig) -> Iterator[JointCone]:
    for index, name in enumerate(type(links).model_fields):
        link = getattr(links, name)
        for key, at_platform in (("platform_cone", True), ("cart_cone", False)):
            if (cone := getattr(link, key)) is not None:
                axis = np.array(cone.axis)
                # Tiny numbers have squares that vanish.
                unit = axis / np.abs(axis).max()
                unit /= np.linalg.norm(unit)
                yield JointCone(index, at_platform, unit, cone.half_angle_deg, f"machine.links.{name}.{key}")
