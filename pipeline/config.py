"""The configuration: one YAML file that describes machine, task and the options of every stage.

Units are part of the key names. Unknown keys are refused; every message names the key's path, the value
found there and what is allowed. `config_file.load_config` reads a file; `Config.model_json_schema()` is its schema.
"""

from typing import Annotated, Literal, Self, TypeVar

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator
from pydantic_core import PydanticCustomError

MODE_PATTERN = "^[LR]{3}$"
NAME_PATTERN = r"^(\w[\w.-]*)?$"

# Bounds that no Gantry-Tau exceeds: they are there to catch a value given in the wrong unit.
Length = Annotated[float, Field(ge=-20.0, le=20.0)]
PositiveLength = Annotated[float, Field(gt=0.0, le=20.0)]
Tilt = Annotated[float, Field(ge=-85.0, le=85.0)]
Vector = tuple[Length, Length, Length]
Interval = tuple[Length, Length]


class Section(BaseModel):
    """A part of the configuration: immutable, unknown keys refused, no NaN and no infinity."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    @field_validator("*", mode="before")
    @classmethod
    def _no_truth_value(cls, value: object) -> object:
        # No key is a truth value, but pydantic takes `yes` for the number 1.
        if any(isinstance(item, bool) for item in (value if isinstance(value, list) else [value])):
            raise PydanticCustomError("truth_value", "true and false are no values here")
        return value


_S = TypeVar("_S", bound=Section)


class RailConfig(Section):
    """A rail parallel to X and the travel of its cart."""

    y_m: Length = Field(description="position of the rail across the frame")
    z_m: Length = Field(description="height of the rail")
    travel_m: Interval = Field(description="[least, largest] cart position along X")

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        return _require_ordered(self, "travel_m", self.travel_m)


class FixedLinkConfig(Section):
    """A link of fixed length between a cart and the platform."""

    platform_point_m: Vector = Field(description="joint on the platform, in the platform frame")
    cart_offset_m: Vector = Field((0.0, 0.0, 0.0), description="joint on the cart, from the cart's origin")
    length_m: PositiveLength = Field(description="distance between the two joints")


class TriangleLinkConfig(Section):
    """Link 3c, which forms the rigid triangle with 3a; a right angle at the platform when no length is given."""

    platform_point_m: Vector = Field(description="joint on the platform, in the platform frame")
    cart_offset_m: Vector = Field((0.0, 0.0, 0.0), description="joint on the cart, from the cart's origin")
    length_m: PositiveLength | None = Field(
        None,
        description="distance between the two joints; null: right angle between 3a and the platform side",
    )


class TelescopeConfig(Section):
    """A link of variable length: an actuator."""

    platform_point_m: Vector = Field(description="joint on the platform, in the platform frame")
    cart_offset_m: Vector = Field((0.0, 0.0, 0.0), description="joint on the cart, from the cart's origin")
    stroke_m: tuple[PositiveLength, PositiveLength] = Field(description="[least, largest] length")

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        return _require_ordered(self, "stroke_m", self.stroke_m)


class LinksConfig(Section):
    """The six links; the digit is the arm (and rail) they belong to."""

    l1: FixedLinkConfig
    l2a: FixedLinkConfig
    l2b: TelescopeConfig
    l3a: FixedLinkConfig
    l3b: TelescopeConfig
    l3c: TriangleLinkConfig


class ActuatorLimitsConfig(Section):
    """What one kind of actuator can do."""

    velocity_mps: float = Field(gt=0.0, le=20.0)
    acceleration_mps2: float = Field(gt=0.0, le=500.0)


class LimitsConfig(Section):
    """Limits of the five actuators."""

    carts: ActuatorLimitsConfig
    telescopes: ActuatorLimitsConfig


class ClearanceConfig(Section):
    """Least distances between axes (link diameter plus margin)."""

    link_link_m: float = Field(ge=0.0, le=1.0, description="between any two links that share no joint")
    link_rail_m: float | None = Field(
        None, ge=0.0, le=1.0, description="between a link and another arm's rail; null: not checked"
    )


class MachineConfig(Section):
    """The machine: everything its kinematics, clearances and limits depend on."""

    rails: tuple[RailConfig, RailConfig, RailConfig] = Field(description="rails of arms 1, 2, 3")
    links: LinksConfig
    triangle_branch: Literal["negative", "positive"] = Field(
        "negative", description="sign of y_platform . (w x u_3c) that the assembled machine keeps"
    )
    clearance: ClearanceConfig
    limits: LimitsConfig

    @model_validator(mode="after")
    def _triangle_closes(self) -> Self:
        first, third = self.links.l3a, self.links.l3c
        side = np.subtract(third.platform_point_m, first.platform_point_m)
        base = np.linalg.norm(np.subtract(third.cart_offset_m, first.cart_offset_m))
        if not side[[0, 2]].any():
            raise _wrong(
                "links.l3c.platform_point_m", "must not lie on the line through 3a's along y: nothing holds ry"
            )
        if third.length_m is None and base > 0.0:
            raise _wrong(
                "links.l3c.length_m", "is missing; it can be left out only when 3a and 3c have one cart_offset_m"
            )
        if third.length_m is not None and abs(third.length_m - first.length_m) > np.linalg.norm(side) + base:
            raise _wrong(
                "links.l3c.length_m",
                f"is {third.length_m:g}, which cannot close the triangle with link 3a ({first.length_m:g} m) and "
                f"the platform side ({np.linalg.norm(side):g} m)",
            )
        return self


class PoseConfig(Section):
    """A controlled pose and the working mode the machine is in there."""

    x_m: Length
    y_m: Length
    z_m: Length
    rx_deg: Tilt = 0.0
    rz_deg: Tilt = 0.0
    mode: Annotated[str, Field(pattern=MODE_PATTERN, description="working mode, L or R per arm, e.g. LLL")]


class BoxConfig(Section):
    """A box of controlled poses, [least, largest] each; a coordinate that is left out may have any value."""

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
            _require_ordered(self, key, interval)
        return self


_BOX_KEYS = ("x_m", "y_m", "z_m", "rx_deg", "rz_deg")
_BOX_NAMES = ", ".join(_BOX_KEYS)


class VisitConfig(Section):
    """Something to visit on the way: one pose, or any pose of a box; exactly one of the two.

    Each visit is a step of the route of its own: the start and the goal make none, and one region makes one at most.
    """

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
            raise _wrong("modes", "goes with box; a pose has its own mode")
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
    """What is to be done: from where to where, what to visit and avoid, and what may be used up on the way."""

    start: PoseConfig
    goal: PoseConfig
    visit: tuple[VisitConfig, ...] = Field(
        (), description="what to visit on the way, in this order, each by a step of its own between start and goal"
    )
    avoid: tuple[BoxConfig, ...] = Field((), description="boxes the TCP must not enter (with tilts: that tilted)")
    budget: BudgetConfig = Field(default_factory=lambda: BudgetConfig())
    tilt_max_deg: float = Field(30.0, ge=0.0, le=85.0, description="largest |rx| and |rz| anywhere")
    locked_axes: tuple[Literal["rx", "rz"], ...] = Field(
        (), description="tilt axes held at zero (the 4-DOF machines: one; the 3-DOF machine: both)"
    )

    @model_validator(mode="after")
    def _poses_within_limits(self) -> Self:
        if len(set(self.locked_axes)) < len(self.locked_axes):
            raise _wrong("locked_axes", f"is [{', '.join(self.locked_axes)}]; allowed is each axis once")
        visited = ((f"visit[{k}].pose", visit.pose) for k, visit in enumerate(self.visit) if visit.pose is not None)
        for key, pose in (("start", self.start), ("goal", self.goal), *visited):
            for axis, value in (("rx", pose.rx_deg), ("rz", pose.rz_deg)):
                limit = 0.0 if axis in self.locked_axes else self.tilt_max_deg
                if abs(value) > limit:
                    why = "task.locked_axes" if axis in self.locked_axes else "task.tilt_max_deg"
                    raise _wrong(f"{key}.{axis}_deg", f"is {value:g}; allowed is at most {limit:g} either way ({why})")
        return self


class AxisConfig(Section):
    """Grid points from `min` to `max`, `step` apart."""

    min: Length
    max: Length
    step: PositiveLength

    @model_validator(mode="after")
    def _not_empty(self) -> Self:
        if self.min > self.max:
            raise _wrong("max", f"is {self.max:g}, below min ({self.min:g}): the grid is empty")
        return self


class GridConfig(Section):
    """Where regions are: y and z of the TCP, and tilts that are multiples of a step up to the tilt limit."""

    y_m: AxisConfig
    z_m: AxisConfig
    rx_step_deg: float = Field(gt=0.0, le=85.0)
    rz_step_deg: float = Field(gt=0.0, le=85.0)


class FollowConfig(Section):
    """How the moves of a route are followed continuously, and what they may do beyond the regions' limits."""

    max_samples: int = Field(
        1024, ge=8, le=16_384, description="parts a move is cut into at most; most are settled by four"
    )
    tilt_overshoot_deg: float = Field(
        1.0, ge=0.0, le=10.0, description="tilt beyond tilt_max_deg accepted between two regions at the limit"
    )


class RouteConfig(Section):
    """Stage one: regions, moves and the mixed-integer program."""

    grid: GridConfig
    x_step_m: PositiveLength = Field(0.1, description="largest move along X per step, (13)")
    step_budget: int = Field(25, ge=2, le=500, description="N, the number of positions of the paper")
    objective: Literal["sum", "bottleneck"] = Field(
        "sum", description="least sum of kappa (5), or least largest kappa and then least sum"
    )
    alternative: int = Field(1, ge=1, le=10, description="which of the best routes: 1 is the best")
    alternative_distance: float = Field(
        3.0,
        ge=0.0,
        le=100.0,
        description="grid steps by which an alternative strays somewhere from every better route; where its working "
        "mode is another it is farther than any distance",
    )
    avoid_margin: float = Field(
        0.25, ge=0.0, le=2.0, description="grid steps that regions keep from the boxes of task.avoid"
    )
    kappa_max: float = Field(100.0, gt=1.0, description="regions and moves with a larger kappa are not admitted")
    threshold_margin: float = Field(
        0.002, gt=0.0, le=3.0, description="first guess of how far the optimum lies above its bound, relative"
    )
    max_rounds: int = Field(50, ge=1, le=10_000, description="rounds of following, forbidding and solving again")
    formulation: Literal["core", "compact", "paper"] = Field(
        "core", description="the program that is solved; compact and paper are over all regions, for small grids"
    )
    time_limit_s: float = Field(600.0, gt=0.0, description="for one solve of the mixed-integer program")
    memory_gb: float = Field(4.0, gt=0.0, le=10_000.0, description="memory that regions and moves may take up")
    follow: FollowConfig = Field(default_factory=lambda: FollowConfig())


class RefineConfig(Section):
    """Stage two: splines in actuator space and the nonlinear program that shapes them."""

    nodes: int = Field(100, ge=20, le=2_000, description="collocation nodes of the first mesh")
    coefficients: int = Field(30, ge=8, le=400, description="spline coefficients per actuator of the first mesh")
    tolerance: float = Field(
        0.002,
        gt=0.0,
        le=1.0,
        description="the mesh is fine enough when a finer one changes the integral of kappa by less, relatively",
    )
    max_meshes: int = Field(
        4, ge=1, le=20, description="meshes tried at most, each finer than the one before; 1: no finer"
    )
    objective: Literal["integral", "maximum", "mixed"] = Field(
        "integral", description="what is minimised: the integral of kappa, the largest kappa, or both"
    )
    kappa_max: float | None = Field(None, gt=1.0, description="cap on kappa along the path; null: route.kappa_max")
    surrogate: Literal["schatten", "frobenius"] = Field(
        "schatten", description="the smooth kappa the solver sees; the true kappa is reported"
    )
    corridor: Literal["cells", "free"] = Field(
        "cells", description="keep to the cells of the route, or only to its sequence of working modes"
    )
    corridor_cells: float = Field(1.0, ge=0.0, le=50.0, description="cells a corridor of cells is widened by")
    start_direction: Vector | None = Field(
        None, description="(x, y, z) the TCP leaves the start in, not tilting; null: any"
    )
    goal_direction: Vector | None = Field(
        None, description="(x, y, z) the TCP comes to the goal in, not tilting; null: any"
    )
    clearance_margin_m: float = Field(0.001, ge=0.0, le=0.1, description="kept at the nodes on top of the clearance")
    tilt_margin_deg: float = Field(0.1, ge=0.0, le=10.0, description="kept at the nodes below the tilt limit")
    lock_tolerance_deg: float = Field(0.25, gt=0.0, le=10.0, description="how far a locked axis may stray from zero")
    check_points: int = Field(10_000, ge=1_000, le=1_000_000, description="poses of the check between the nodes")
    max_rounds: int = Field(5, ge=1, le=50, description="solves, each with nodes added where the check failed")
    max_iterations: int = Field(1_000, ge=1, le=100_000, description="IPOPT iterations per solve")
    time_limit_s: float = Field(600.0, gt=0.0, description="for one solve")

    @model_validator(mode="after")
    def _directions_point_somewhere(self) -> Self:
        for key in ("start_direction", "goal_direction"):
            if getattr(self, key) == (0.0, 0.0, 0.0):
                raise _wrong(key, "is [0, 0, 0]; allowed is any other direction")
        return self

    @model_validator(mode="after")
    def _enough_nodes(self) -> Self:
        if self.coefficients > self.nodes:
            raise _wrong("coefficients", f"is {self.coefficients}; allowed are at most as many as nodes ({self.nodes})")
        return self


class RetimeConfig(Section):
    """Stage three: the path in time."""

    grid_points: int = Field(
        1_000,
        ge=50,
        le=20_000,
        description="points of the first TOPP-RA grid; doubled while limits are broken between them",
    )
    period_s: float = Field(0.01, ge=0.000_125, le=0.1, description="sampling period of trajectory.csv")


class Config(Section):
    """The whole configuration of one run."""

    name: str = Field("", pattern=NAME_PATTERN, description="name of the run; default: the file's name")
    machine: MachineConfig
    task: TaskConfig
    route: RouteConfig
    refine: RefineConfig = Field(default_factory=lambda: RefineConfig())
    retime: RetimeConfig = Field(default_factory=lambda: RetimeConfig())


def _require_ordered(section: _S, key: str, interval: tuple[float, float]) -> _S:
    if interval[0] >= interval[1]:
        raise _wrong(key, f"is {list(interval)}; allowed is [least, largest] with least below largest")
    return section


def _wrong(key: str, message: str) -> PydanticCustomError:
    """Make the error of a rule that involves several keys; `key` is the one to look at, from the section on."""
    return PydanticCustomError("rule", "{key} {message}", {"key": key, "message": message})
