"""Bodies of the machine: sphere-swept convex shapes, what they are attached to, and how far apart they stay."""

from collections import Counter
from collections.abc import Iterable
from typing import Annotated, ClassVar, Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from pipeline.config.choices import BodyFrame
from pipeline.config.section import Interval, PositiveLength, Section, Vector, wrong

BODY_PATTERN = r"^\w+([.-]\w+)*$"
_MOST_BODIES, _MOST_POINTS, _MOST_NAME, _MOST_IGNORED = 100, 64, 40, 1_000
Radius = Annotated[float, Field(ge=0.0, le=20.0)]
BodyName = Annotated[str, Field(pattern=BODY_PATTERN, max_length=_MOST_NAME)]


class CapsuleConfig(Section):
    """All points within a radius of a segment; a sphere if both ends are the same."""

    on_one_line: ClassVar[bool] = True

    from_m: Vector
    to_m: Vector
    radius_m: PositiveLength


class BodyBoxConfig(Section):
    """A box along the axes of the frame, its edges rounded."""

    on_one_line: ClassVar[bool] = True

    centre_m: Vector = (0.0, 0.0, 0.0)
    size_m: tuple[PositiveLength, PositiveLength, PositiveLength]
    rounding_m: Radius = Field(0.0, description="radius of the edges, which are inside the box")

    @model_validator(mode="after")
    def _rounding_fits(self) -> Self:
        if 2.0 * self.rounding_m > min(self.size_m):
            raise wrong("rounding_m", f"is {self.rounding_m:g}; allowed is at most half the least side of size_m")
        return self


class HullConfig(Section):
    """All points within a radius of the convex hull of points."""

    on_one_line: ClassVar[bool] = True

    points_m: tuple[Vector, ...] = Field(min_length=1, max_length=_MOST_POINTS)
    radius_m: Radius = 0.0


class BeamConfig(Section):
    """A convex profile, endless along X: all points within a radius of the hull of its corners (y, z)."""

    on_one_line: ClassVar[bool] = True

    points_m: tuple[Interval, ...] = Field(
        min_length=1, max_length=_MOST_POINTS, description="corners (y, z), from the rail or in the frame"
    )
    radius_m: Radius = 0.0


class BodyConfig(Section):
    """A convex body: exactly one of capsule, box, hull and beam, in the axes of what it is attached to."""

    on_one_line: ClassVar[bool] = True

    name: BodyName = Field(description="names the body in messages")
    attached_to: BodyFrame = Field(
        description="platform (from the TCP), cart1 to cart3 (from the cart's origin), "
        "rail1 to rail3 (from the rail), or frame"
    )
    capsule: CapsuleConfig | None = Field(None, exclude_if=lambda value: value is None)
    box: BodyBoxConfig | None = Field(None, exclude_if=lambda value: value is None)
    hull: HullConfig | None = Field(None, exclude_if=lambda value: value is None)
    beam: BeamConfig | None = Field(None, exclude_if=lambda value: value is None)

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        given = [key for key in ("capsule", "box", "hull", "beam") if getattr(self, key) is not None]
        if len(given) != 1:
            found = f"has {' and '.join(given)}" if given else "has no shape"
            raise PydanticCustomError(
                "rule", "{found}: give exactly one of capsule, box, hull and beam", {"found": found}
            )
        fixed = self.attached_to in (BodyFrame.RAIL1, BodyFrame.RAIL2, BodyFrame.RAIL3, BodyFrame.FRAME)
        if self.beam is not None and not fixed:
            raise wrong(
                "beam", f"is endless along X and moves with {self.attached_to}; attach it to a rail or the frame"
            )
        if self.beam is None and fixed:
            raise wrong(
                "attached_to",
                f"is {self.attached_to}; what is fixed there can only be a beam, endless along X: distances must not "
                "depend on x",
            )
        return self


class LinkBodyConfig(Section):
    """A link of fixed length as a rod about its axis."""

    on_one_line: ClassVar[bool] = True

    radius_m: PositiveLength


class TelescopeBodyConfig(Section):
    """A telescope: a rod all along its axis, within a tube that begins at the cart joint."""

    on_one_line: ClassVar[bool] = True

    rod_radius_m: PositiveLength
    tube_radius_m: PositiveLength
    tube_length_m: PositiveLength = Field(description="from the cart joint along the axis")

    @model_validator(mode="after")
    def _tube_is_wider(self) -> Self:
        if self.tube_radius_m < self.rod_radius_m:
            raise wrong("tube_radius_m", f"is {self.tube_radius_m:g}; allowed is at least rod_radius_m")
        return self


class LinkBodiesConfig(Section):
    """The six links as bodies; without them links are axes."""

    l1: LinkBodyConfig
    l2a: LinkBodyConfig
    l2b: TelescopeBodyConfig
    l3a: LinkBodyConfig
    l3b: TelescopeBodyConfig
    l3c: LinkBodyConfig


class JointTrimConfig(Section):
    """What is left out at the end of a link where it is checked against what its joint sits on."""

    on_one_line: ClassVar[bool] = True

    platform: float = Field(0.08, ge=0.0, le=1.0, description="at the platform joint, metres")
    cart: float = Field(0.12, ge=0.0, le=1.0, description="at the cart joint, metres")


IgnoredPairs = Annotated[tuple[tuple[BodyName, BodyName], ...], Field(max_length=_MOST_IGNORED)]
Bodies = Annotated[tuple[BodyConfig, ...], Field(max_length=_MOST_BODIES)]
LINK_NAMES = tuple(LinkBodiesConfig.model_fields)


def require_names(bodies: Iterable[BodyConfig], ignored: Iterable[tuple[str, str]]) -> None:
    """Refuse names that are given twice, are those of links, or are ignored without being known."""
    names = [body.name for body in bodies]
    twice = [name for name, count in Counter([*names, *LINK_NAMES]).items() if count > 1]
    if twice:
        raise wrong("bodies", f"has {twice[0]} more than once, or as the name of a link; every body needs its own name")
    known = {*names, *LINK_NAMES}
    for pair in ignored:
        for name in pair:
            if name not in known:
                raise wrong(
                    "clearance.ignore", f"names {name}; allowed are the names of bodies and {', '.join(LINK_NAMES)}"
                )
