"""Stage one: the grid of regions, the mixed-integer program, and how moves are followed."""

from typing import ClassVar, Self

from pydantic import Field, model_validator

from pipeline.config.choices import Formulation, RouteObjective
from pipeline.config.section import Length, PositiveLength, Section, wrong


class AxisConfig(Section):
    """Grid points, `step` apart from `min` to `max`."""

    on_one_line: ClassVar[bool] = True

    min: Length
    max: Length
    step: PositiveLength

    @model_validator(mode="after")
    def _not_empty(self) -> Self:
        if self.min > self.max:
            raise wrong("max", f"is {self.max:g}, below min ({self.min:g}): the grid is empty")
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


_COUNTED_BY_STEP = (RouteObjective.SUM, RouteObjective.BOTTLENECK)
"""Objectives that add up kappa step by step, whatever a step's travel along X."""


class RouteConfig(Section):
    """Stage one: regions, moves and the mixed-integer program."""

    grid: GridConfig
    x_step_m: PositiveLength = Field(0.1, description="largest move along X per step, (13)")
    step_budget: int = Field(40, ge=2, le=500, description="most positions of a route: N in the paper")
    objective: RouteObjective = Field(
        RouteObjective.INTEGRAL,
        description="integral: kappa integrated over the length of the moves, which stage two minimises; sum: the sum "
        "of kappa over the steps (5); bottleneck: the largest kappa, then the sum; time: the seconds that the moves, "
        "one by one, take at the velocity limits",
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
        0.25,
        ge=0.0,
        le=2.0,
        description="grid steps that regions keep from task.avoid, and along X from obstacles",
    )
    kappa_max: float = Field(100.0, gt=1.0, description="regions and moves with a larger kappa are not admitted")
    threshold_margin: float = Field(
        0.002, gt=0.0, le=3.0, description="first guess of how far the optimum lies above its bound, relative"
    )
    max_rounds: int = Field(50, ge=1, le=10_000, description="rounds of following, forbidding and solving again")
    formulation: Formulation = Field(
        Formulation.CORE,
        description="the program that is solved; compact, paper: over all regions, for small grids",
    )
    time_limit_s: float = Field(
        300.0, gt=0.0, le=1e6, description="for the whole search; the best route so far is then kept"
    )
    memory_gb: float = Field(
        4.0,
        gt=0.0,
        le=10_000.0,
        description="memory that stage one may take up, beside the 0.2 GB of the program itself",
    )
    follow: FollowConfig = Field(default_factory=lambda: FollowConfig())

    @model_validator(mode="after")
    def _programs_count_steps(self) -> Self:
        if self.formulation is not Formulation.CORE and self.objective not in _COUNTED_BY_STEP:
            raise wrong(
                "formulation",
                f"is {self.formulation}, a program in which travel along X costs nothing, but route.objective is "
                f"{self.objective}: set route.objective to sum, or route.formulation to core",
            )
        return self
