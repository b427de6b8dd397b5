"""The task: from where to where, what to visit and avoid, and what may be used up."""

from typing import Annotated, ClassVar, Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from pipeline.config.choices import TiltAxis
from pipeline.config.machine.bodies import Obstacles
from pipeline.config.section import MODE_PATTERN, Interval, Length, Section, Tilt, require_ordered, wrong


class PoseConfig(Section):
    """A controlled pose, and the working mode there: L or R for arms 1, 2, 3."""

    on_one_line: ClassVar[bool] = True

    x_m: Length
    y_m: Length
    z_m: Length
    rx_deg: Tilt = 0.0
    rz_deg: Tilt = 0.0
    mode: Annotated[str, Field(pattern=MODE_PATTERN, description="working mode, L or R per arm, e.g. LLL")]


class BoxConfig(Section):
    """A box of controlled poses, [least, largest] each; a coordinate that is left out may have any value."""

    on_one_line: ClassVar[bool] = True

    x_m: Interval | None = None
    y_m: Interval | None = None
    z_m: Interval | None = None
    rx_deg: tuple[Tilt, Tilt] | None = None
    rz_deg: tuple[Tilt, Tilt] | None = None

    @model_validator(mode="after")
    def _not_empty(self) -> Self:
        given = {key: interval for key in _BOX_KEYS if (interval := getattr(self, key)) is not None}
        if not given:
            raise PydanticCustomError("rule", "has no coordinate: give at least one of {keys}", {"keys": _BOX_NAMES})
        for key, interval in given.items():
            require_ordered(self, key, interval)
        return self


_BOX_KEYS = ("x_m", "y_m", "z_m", "rx_deg", "rz_deg")
_BOX_NAMES = ", ".join(_BOX_KEYS)


class VisitConfig(Section):
    """Something to visit on the way: one pose, or any pose of a box; exactly one of the two.

    Each visit is a step of the route of its own: the start and the goal make none, and one region makes one at most.
    """

    on_one_line: ClassVar[bool] = True

    pose: PoseConfig | None = Field(None, description="a pose, in its working mode")
    box: BoxConfig | None = Field(None, description="anywhere in a box")
    modes: tuple[Annotated[str, Field(pattern=MODE_PATTERN)], ...] = Field(
        (), description="working modes the box may be visited in; none: in any"
    )

    @model_validator(mode="after")
    def _one_of_two(self) -> Self:
        if (self.pose is None) == (self.box is None):
            raise PydanticCustomError("rule", "needs exactly one of pose and box")
        if self.pose is not None and self.modes:
            raise wrong("modes", "goes with box; a pose has its own mode")
        return self


class BudgetConfig(Section):
    """What the route may use up in all; what is left out is not limited."""

    mode_changes: int | None = Field(None, ge=0, le=1_000, description="changes of working mode, counted per arm")
    tilt_deg: float | None = Field(
        None, gt=0.0, le=100_000.0, description="sum of all changes of rx and rz from step to step"
    )
    travel_m: float | None = Field(
        None, gt=0.0, le=1_000.0, description="sum of all changes of x, y and z from step to step"
    )


class TaskConfig(Section):
    """The task: from where to where, what to visit and avoid, and what may be used up on the way."""

    start: PoseConfig
    goal: PoseConfig
    visit: tuple[VisitConfig, ...] = Field(
        (),
        max_length=100,
        description="what to visit on the way, in this order, each by a step of its own after the start, such as "
        "{pose: {x_m: 1.02, y_m: 0.3, z_m: 0.9, mode: LRL}} or {box: {y_m: [0.3, 0.5], z_m: [0.6, 0.8]}}",
    )
    avoid: tuple[BoxConfig, ...] = Field(
        (),
        max_length=200,
        description="boxes the TCP must not enter (with tilts: so tilted), such as {y_m: [0.4, 0.5], z_m: [0.5, 0.7]}",
    )
    obstacles: Obstacles = Field(
        (),
        description="convex bodies fixed in space that nothing of the machine may touch, such as "
        "{name: workpiece, box: {centre_m: [1, -0.1, 0.7], size_m: [0.4, 0.3, 0.3]}}",
        exclude_if=lambda value: not value,
    )
    tool: Obstacles = Field(
        (),
        description="bodies of the tool in this task, in the platform's axes from the TCP; they replace the machine's "
        "bodies with tool: on",
        exclude_if=lambda value: not value,
    )
    budget: BudgetConfig = Field(default_factory=lambda: BudgetConfig())
    tilt_max_deg: float = Field(30.0, ge=0.0, le=85.0, description="largest |rx| and |rz| anywhere")
    locked_axes: tuple[TiltAxis, ...] = Field(
        (), description="tilt axes held at zero (the 4-DOF machines: one; the 3-DOF machine: both)"
    )

    @model_validator(mode="after")
    def _poses_within_limits(self) -> Self:
        if len(set(self.locked_axes)) < len(self.locked_axes):
            raise wrong("locked_axes", f"is [{', '.join(self.locked_axes)}]; allowed is each axis once")
        visited = ((f"visit[{k}].pose", visit.pose) for k, visit in enumerate(self.visit) if visit.pose is not None)
        for key, pose in (("start", self.start), ("goal", self.goal), *visited):
            if fault := self.tilt_fault(key, pose):
                raise fault
        return self

    def tilt_fault(self, key: str, pose: PoseConfig) -> PydanticCustomError | None:
        """Make the error of a pose, found at a key, that is tilted more than allowed; None if it is not."""
        for axis, value in (("rx", pose.rx_deg), ("rz", pose.rz_deg)):
            limit = 0.0 if axis in self.locked_axes else self.tilt_max_deg
            if abs(value) > limit:
                why = "task.locked_axes" if axis in self.locked_axes else "task.tilt_max_deg"
                return wrong(f"{key}.{axis}_deg", f"is {value:g}; allowed is at most {limit:g} either way ({why})")
        return None
