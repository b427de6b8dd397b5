"""Rails, links and the least distances between them."""

from typing import ClassVar, Self

from pydantic import Field, model_validator

from pipeline.config.machine.bodies import IgnoredPairs, JointTrimConfig
from pipeline.config.section import Interval, Length, PositiveLength, Section, Vector, require_ordered


class RailConfig(Section):
    """A rail parallel to X and the travel of its cart."""

    on_one_line: ClassVar[bool] = True

    y_m: Length = Field(description="position of the rail across the frame")
    z_m: Length = Field(description="height of the rail")
    travel_m: Interval = Field(description="[least, largest] cart position along X")

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        return require_ordered(self, "travel_m", self.travel_m)


class FixedLinkConfig(Section):
    """A link of fixed length between a cart and the platform."""

    on_one_line: ClassVar[bool] = True

    platform_point_m: Vector = Field(description="joint on the platform, in the platform frame")
    cart_offset_m: Vector = Field((0.0, 0.0, 0.0), description="joint on the cart, from the cart's origin")
    length_m: PositiveLength = Field(description="distance between the two joints")


class TriangleLinkConfig(Section):
    """Link 3c of the rigid triangle with 3a; without a length, at a right angle to the platform side."""

    on_one_line: ClassVar[bool] = True

    platform_point_m: Vector = Field(description="joint on the platform, in the platform frame")
    cart_offset_m: Vector = Field((0.0, 0.0, 0.0), description="joint on the cart, from the cart's origin")
    length_m: PositiveLength | None = Field(
        None,
        description="distance between the two joints; null: right angle between 3a and the platform side",
    )


class TelescopeConfig(Section):
    """A link of variable length: an actuator."""

    on_one_line: ClassVar[bool] = True

    platform_point_m: Vector = Field(description="joint on the platform, in the platform frame")
    cart_offset_m: Vector = Field((0.0, 0.0, 0.0), description="joint on the cart, from the cart's origin")
    stroke_m: tuple[PositiveLength, PositiveLength] = Field(description="[least, largest] length")

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        return require_ordered(self, "stroke_m", self.stroke_m)


class LinksConfig(Section):
    """The six links; the digit is their arm (and rail): joints on platform and cart, length or stroke."""

    l1: FixedLinkConfig
    l2a: FixedLinkConfig
    l2b: TelescopeConfig
    l3a: FixedLinkConfig
    l3b: TelescopeConfig
    l3c: TriangleLinkConfig


OF_BODIES = {"bodies_m", "joint_trim_m", "ignore"}
"""Keys of clearances that are of bodies; left out where they are not given."""


class ClearanceConfig(Section):
    """Least distances between axes (link diameter plus margin), and between the surfaces of bodies."""

    link_link_m: float | None = Field(
        None,
        ge=0.0,
        le=1.0,
        description="between axes of any two links that share no joint; left out where machine.link_bodies is given",
    )
    link_rail_m: float | None = Field(
        None, ge=0.0, le=1.0, description="between a link and another arm's rail; null: not checked"
    )
    bodies_m: float = Field(
        0.005,
        ge=0.0,
        le=1.0,
        description="between the surfaces of any two bodies; links without bodies are their axes",
        exclude_if=lambda value: value == 0.005,
    )
    joint_trim_m: JointTrimConfig = Field(
        default_factory=lambda: JointTrimConfig(),
        description="length of a link that is left out at a joint, where it is checked against what the joint sits on",
        exclude_if=lambda value: value == JointTrimConfig(),
    )
    ignore: IgnoredPairs = Field(
        (),
        description="pairs of bodies or links that are not checked, such as [nose, l3a]",
        exclude_if=lambda value: not value,
    )
