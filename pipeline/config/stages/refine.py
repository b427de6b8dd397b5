"""Stage two: meshes, objective, corridor, margins and checks of the smooth path."""

from typing import Self

from pydantic import Field, model_validator

from pipeline.config.choices import Corridor, PathObjective
from pipeline.config.section import Section, Vector, wrong


class RefineConfig(Section):
    """Stage two: splines in actuator space and the nonlinear program that shapes them."""

    nodes: int = Field(100, ge=20, le=2_000, description="collocation nodes of the first mesh")
    coefficients: int = Field(30, ge=8, le=400, description="spline coefficients per actuator of the first mesh")
    tolerance: float = Field(
        0.002,
        gt=0.0,
        le=1.0,
        description="the mesh is fine enough if a finer one changes the objective by less than this, relatively",
    )
    max_meshes: int = Field(
        4, ge=1, le=20, description="meshes tried at most, each finer than the one before; 1: no finer"
    )
    objective: PathObjective = Field(
        PathObjective.INTEGRAL,
        description="integral of kappa; maximum: the largest kappa; mixed: mean and largest alike; time: duration, "
        "path and time law together",
    )
    time_weight: float = Field(
        1.0,
        gt=0.0,
        le=1_000.0,
        description="objective time: weight w of the integral of kappa in T / T_ref + w K / K_ref; less is faster",
    )
    smoothness: float = Field(
        1e-6,
        ge=0.0,
        le=1.0,
        description="weight of the third derivative of the actuators along the path, relative to the coarse path's "
        "integral of kappa; 0: none",
    )
    kappa_max: float | None = Field(None, gt=1.0, description="cap on kappa along the path; null: route.kappa_max")
    corridor: Corridor = Field(
        Corridor.CELLS, description="cells: those of the route, and its working modes in order; free: the modes alone"
    )
    corridor_cells: float = Field(3.0, ge=0.0, le=50.0, description="cells a corridor of cells is widened by")
    start_direction: Vector | None = Field(
        None, description="(x, y, z) of the TCP's path at the very start, not tilting; null: any"
    )
    goal_direction: Vector | None = Field(
        None, description="(x, y, z) of the TCP's path at the very goal, not tilting; null: any"
    )
    approach_m: float | None = Field(
        None,
        ge=0.005,
        le=0.5,
        description="length over which the path keeps to these directions, within 3 degrees and hardly tilting, with "
        "poses to pass at their ends; null: at the very ends only",
    )
    clearance_margin_m: float = Field(0.001, ge=0.0, le=0.1, description="kept at the nodes on top of the clearance")
    travel_margin_m: float = Field(
        0.005, ge=0.0, le=1.0, description="route and path stay so far from the ends of the rails"
    )
    stroke_margin_m: float = Field(
        0.002, ge=0.0, le=1.0, description="route and path stay so far from the ends of the strokes"
    )
    tilt_margin_deg: float = Field(0.1, ge=0.0, le=10.0, description="kept at the nodes below the tilt limit")
    lock_tolerance_deg: float = Field(0.25, gt=0.0, le=10.0, description="how far a locked axis may stray from zero")
    check_points: int = Field(10_000, ge=1_000, le=1_000_000, description="poses of the check between the nodes")
    max_rounds: int = Field(5, ge=1, le=50, description="checks between the nodes; nodes are added where one fails")
    max_iterations: int = Field(
        1_000, ge=1, le=100_000, description="iterations of one solve by IPOPT, and steps of a sequential program"
    )
    time_limit_s: float = Field(600.0, gt=0.0, le=1e6, description="for one solve by IPOPT")

    @model_validator(mode="after")
    def _directions_point_somewhere(self) -> Self:
        for key in ("start_direction", "goal_direction"):
            if getattr(self, key) == (0.0, 0.0, 0.0):
                raise wrong(key, "is [0, 0, 0]; allowed is any other direction")
        return self

    @model_validator(mode="after")
    def _approach_has_a_direction(self) -> Self:
        if self.approach_m is not None and self.start_direction is None and self.goal_direction is None:
            raise wrong("approach_m", f"is {self.approach_m:g}; it needs start_direction, goal_direction or both")
        return self

    @model_validator(mode="after")
    def _enough_nodes(self) -> Self:
        if self.coefficients > self.nodes:
            raise wrong("coefficients", f"is {self.coefficients}; allowed are at most as many as nodes ({self.nodes})")
        return self
