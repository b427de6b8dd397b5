"""Rails, links and the least distances between them."""

from typing import Annotated, ClassVar, Self

from pydantic import Field, model_validator

from pipeline.config.machine.bodies import IgnoredPairs, JointTrimConfig
from pipeline.config.section import Interval, Length, PositiveLength, Section, Vector, require_ordered, wrong

SHARED_JOINT_M = 0.002
"""How far apart joints of two links are that count as one, by default: more than a calibration moves them."""


STEEPEST_SLOPE = 0.005
"""How far a rail may be off X: regions and moves are found for parallel rails, and more would lead them astray."""
Slope = Annotated[float, Field(ge=-STEEPEST_SLOPE, le=STEEPEST_SLOPE)]


class RailConfig(Section):
    """A straight rail, parallel to X or nearly so, and the travel of its cart."""

    on_one_line: ClassVar[bool] = True

    y_m: Length = Field(description="position of the rail across the frame, where x is 0")
    z_m: Length = Field(description="height of the rail, where x is 0")
    travel_m: Interval = Field(description="[least, largest] cart position along the rail, from where x is 0")
    slopes: tuple[Slope, Slope] = Field(
        (0.0, 0.0),
        description="[dy/dx, dz/dx] of the rail, as a calibration finds them, at most 0.005: the cart at q is at "
        "[0, y_m, z_m] + q [1, dy/dx, dz/dx] / sqrt(1 + (dy/dx)^2 + (dz/dx)^2), and does not turn",
        exclude_if=lambda value: value == (0.0, 0.0),
    )

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        return require_ordered(self, "travel_m", self.travel_m)


class JointConeConfig(Section):
    """How far a spherical or universal joint can turn: the link leaves it within a cone."""

    on_one_line: ClassVar[bool] = True

    axis: Vector = Field(
        description="where the link points, from this joint to its other one, in the middle of the joint; of any "
        "length, in the platform's frame or, for a joint at a cart, in the cart's, which does not turn"
    )
    half_angle_deg: float = Field(gt=0.0, lt=180.0, description="largest angle between link and axis")

    @model_validator(mode="after")
    def _axis_points_somewhere(self) -> Self:
        if self.axis == (0.0, 0.0, 0.0):
            raise wrong("axis", "is [0, 0, 0]; allowed is any other direction")
        return self


PlatformCone = Annotated[
    JointConeConfig | None,
    Field(
        description="how far its platform joint can turn, {axis: [...], half_angle_deg: ...}; null: not limited",
        exclude_if=lambda cone: cone is None,
    ),
]
CartCone = Annotated[
    JointConeConfig | None,
    Field(
        description="how far its cart joint can turn, {axis: [...], half_angle_deg: ...}; null: not limited",
        exclude_if=lambda cone: cone is None,
    ),
]


class FixedLinkConfig(Section):
    """A link of fixed length between a cart and the platform."""

    on_one_line: ClassVar[bool] = True

    platform_point_m: Vector = Field(description="joint on the platform, in the platform frame")
    cart_offset_m: Vector = Field((0.0, 0.0, 0.0), description="joint on the cart, from the cart's origin")
    length_m: PositiveLength = Field(description="distance between the two joints")
    platform_cone: PlatformCone = None
    cart_cone: CartCone = None


class TriangleLinkConfig(Section):
    """Link 3c of the rigid triangle with 3a; without a length, at a right angle to the platform side."""

    on_one_line: ClassVar[bool] = True

    platform_point_m: Vector = Field(description="joint on the platform, in the platform frame")
    cart_offset_m: Vector = Field((0.0, 0.0, 0.0), description="joint on the cart, from the cart's origin")
    length_m: PositiveLength | None = Field(
        None,
        description="distance between the two joints; null: right angle between 3a and the platform side",
    )
    platform_cone: PlatformCone = None
    cart_cone: CartCone = None


class TelescopeConfig(Section):
    """A link of variable length: an actuator."""

    on_one_line: ClassVar[bool] = True

    platform_point_m: Vector = Field(description="joint on the platform, in the platform frame")
    cart_offset_m: Vector = Field((0.0, 0.0, 0.0), description="joint on the cart, from the cart's origin")
    stroke_m: tuple[PositiveLength, PositiveLength] = Field(description="[least, largest] length")
    platform_cone: PlatformCone = None
    cart_cone: CartCone = None

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
    shared_joint_m: float = Field(
        SHARED_JOINT_M,
        ge=0.0,
        le=0.05,
        description="joints of two links that are at most so far apart are one joint; 0: only in one point",
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
