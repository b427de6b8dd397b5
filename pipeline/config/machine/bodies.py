"""Bodies of the machine: sphere-swept convex shapes, what they are attached to, and how far apart they stay."""

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Annotated, Any, ClassVar, Self, TypeVar

from pydantic import Field, TypeAdapter, ValidationError, ValidationInfo, model_validator
from pydantic_core import PydanticCustomError

from pipeline.config.choices import BodyFrame
from pipeline.config.machine.mesh import MeshConfig
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


class ObstacleConfig(Section):
    """A convex obstacle fixed in space: exactly one of capsule, box, hull and mesh, in the axes of the frame."""

    on_one_line: ClassVar[bool] = True

    name: BodyName = Field(description="names the obstacle in messages")
    capsule: CapsuleConfig | None = Field(None, exclude_if=lambda value: value is None)
    box: BodyBoxConfig | None = Field(None, exclude_if=lambda value: value is None)
    hull: HullConfig | None = Field(None, exclude_if=lambda value: value is None)
    mesh: MeshConfig | None = Field(None, exclude_if=lambda value: value is None)

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        return _require_one(self, ("capsule", "box", "hull", "mesh"))


class BodyConfig(Section):
    """A convex body: exactly one of capsule, box, hull, mesh and beam, in the axes of what it is attached to."""

    on_one_line: ClassVar[bool] = True

    name: BodyName = Field(description="names the body in messages")
    attached_to: BodyFrame = Field(
        description="platform (from the TCP), cart1 to cart3 (from the cart's origin), "
        "rail1 to rail3 (from the rail), frame, or the end of a link (from the joint, z along the link to the platform)"
    )
    capsule: CapsuleConfig | None = Field(None, exclude_if=lambda value: value is None)
    box: BodyBoxConfig | None = Field(None, exclude_if=lambda value: value is None)
    hull: HullConfig | None = Field(None, exclude_if=lambda value: value is None)
    mesh: MeshConfig | None = Field(None, exclude_if=lambda value: value is None)
    beam: BeamConfig | None = Field(None, exclude_if=lambda value: value is None)
    tool: bool = Field(
        False, description="part of the tool, which task.tool replaces", exclude_if=lambda value: not value
    )

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        _require_one(self, ("capsule", "box", "hull", "mesh", "beam"))
        if self.tool and self.attached_to != BodyFrame.PLATFORM:
            raise wrong("tool", f"is on, of a body of {self.attached_to}; tools are on the platform")
        rail = self.attached_to in (BodyFrame.RAIL1, BodyFrame.RAIL2, BodyFrame.RAIL3)
        if self.beam is not None and not rail and self.attached_to != BodyFrame.FRAME:
            raise wrong(
                "beam", f"is endless along X and moves with {self.attached_to}; attach it to a rail or the frame"
            )
        if self.beam is None and rail:
            raise wrong("attached_to", f"is {self.attached_to}, of which a body is a beam; attach others to the frame")
        self._require_on_link()
        return self

    def _require_on_link(self) -> None:
        """Refuse what is not of revolution about the link that it is attached to, or is beyond the link's joint."""
        if (end := self.attached_to.link_end) is None:
            return
        if self.capsule is None:
            raise wrong(
                "attached_to",
                f"is {self.attached_to}, and joints leave open how far a link turns about its axis: only a capsule on "
                "that axis is the same for all",
            )
        for key, point in (("from_m", self.capsule.from_m), ("to_m", self.capsule.to_m)):
            if any(point[:2]):
                raise wrong(f"capsule.{key}", "is off the axis of the link, along z; x and y have to be 0")
            if point[2] * (1.0 - 2.0 * end[1]) < 0.0:
                side = "at most" if end[1] else "at least"
                raise wrong(f"capsule.{key}", f"is beyond the joint; z of a body of {self.attached_to} is {side} 0")


S = TypeVar("S", bound=Section)


def _require_one(section: S, keys: tuple[str, ...]) -> S:
    """Refuse a body without a shape, or with several."""
    given = [key for key in keys if getattr(section, key) is not None]
    if len(given) != 1:
        found = f"has {' and '.join(given)}" if given else "has no shape"
        choice = f"{', '.join(keys[:-1])} and {keys[-1]}"
        raise PydanticCustomError("rule", "{found}: give exactly one of {choice}", {"found": found, "choice": choice})
    return section


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
Obstacles = Annotated[tuple[ObstacleConfig, ...], Field(max_length=_MOST_BODIES)]
Bodies = Annotated[tuple[BodyConfig, ...], Field(max_length=_MOST_BODIES)]
LINK_NAMES = tuple(LinkBodiesConfig.model_fields)


_SHAPES = TypeAdapter(Obstacles)


def with_tool(data: Any, info: ValidationInfo) -> Any:
    """Put the bodies of `task.tool` in the place of the machine's tool, in a configuration as it was read.

    What is wrong with them is said of `task.tool`.
    """
    if not isinstance(data, dict) or not isinstance(machine := data.get("machine"), dict):
        return data
    task, bodies = data.get("task"), machine.get("bodies") or []
    tool = task.get("tool") if isinstance(task, dict) else None
    if not tool or not isinstance(bodies, list | tuple):
        return data
    try:
        _SHAPES.validate_python(tool, context=info.context)
    except ValidationError:
        return data
    kept = [body for body in bodies if not (isinstance(body, dict) and body.get("tool"))]
    added = [{**body, "attached_to": BodyFrame.PLATFORM.value, "tool": True} for body in tool]
    return {**data, "machine": {**machine, "bodies": [*kept, *added]}}


def require_names(key: str, bodies: Sequence[BodyConfig | ObstacleConfig]) -> None:
    """Refuse names that are given twice, or are those of links; `key` is the one to look at."""
    twice = [name for name, count in Counter([*(body.name for body in bodies), *LINK_NAMES]).items() if count > 1]
    if twice:
        raise wrong(key, f"has {twice[0]} more than once, or as the name of a link; every body needs its own name")


def require_known(key: str, ignored: Iterable[tuple[str, str]], bodies: Sequence[BodyConfig | ObstacleConfig]) -> None:
    """Refuse ignored pairs of what is neither a body nor a link."""
    known = {*(body.name for body in bodies), *LINK_NAMES}
    for name in (name for pair in ignored for name in pair if name not in known):
        raise wrong(key, f"names {name}; allowed are the names of bodies and {', '.join(LINK_NAMES)}")
