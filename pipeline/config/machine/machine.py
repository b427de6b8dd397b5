"""The machine: rails, links, triangle, clearances, limits and masses."""

from typing import Self

import numpy as np
from pydantic import Field, model_validator

from pipeline.config.choices import TriangleBranch
from pipeline.config.machine.actuators import ActuatorsConfig
from pipeline.config.machine.limits import LimitsConfig
from pipeline.config.machine.links import ClearanceConfig, LinksConfig, RailConfig
from pipeline.config.machine.masses import DynamicsConfig
from pipeline.config.section import PositiveLength, Section, wrong


class MachineConfig(Section):
    """The machine: everything its kinematics, clearances and limits depend on."""

    rails: tuple[RailConfig, RailConfig, RailConfig] = Field(
        description="of arms 1, 2, 3, along X: where they are, and the travel of their carts"
    )
    links: LinksConfig
    triangle_branch: TriangleBranch = Field(
        TriangleBranch.NEGATIVE, description="sign of y_platform . (w x u_3c) that the assembled machine keeps"
    )
    characteristic_length_m: PositiveLength = Field(
        1.0, description="moments are divided by it for kappa: about the size of the machine"
    )
    clearance: ClearanceConfig
    limits: LimitsConfig
    dynamics: DynamicsConfig | None = Field(
        None, description="masses, for forces and their limits; null: no forces, and no limits of forces either"
    )
    actuators: ActuatorsConfig = Field(
        default_factory=lambda: ActuatorsConfig(),
        description="what the controller's positions q are in this geometry: middle of the range + zero_m + scale (q - "
        "middle); files for controllers are written with it, planning is not concerned",
    )

    def holding(self) -> dict[str, object]:
        """Give the keys that holding forces and their limits follow from; none if no forces are limited."""
        if self.dynamics is None or not self.limits.of_forces():
            return {}
        return {
            "limits": self.limits.holding(),
            "dynamics": self.dynamics.model_dump(mode="json", exclude={"platform": {"inertia_kgm2"}}),
        }

    @model_validator(mode="after")
    def _forces_can_be_computed(self) -> Self:
        if self.dynamics is None and (limited := self.limits.of_forces()):
            raise wrong(
                "dynamics",
                f"is missing, and without masses there are no forces to hold against machine.limits."
                f"{limited[0]}; give it, or leave out {' and '.join(f'machine.limits.{key}' for key in limited)}",
            )
        return self

    @model_validator(mode="after")
    def _triangle_closes(self) -> Self:
        first, third = self.links.l3a, self.links.l3c
        side = np.subtract(third.platform_point_m, first.platform_point_m)
        base = np.linalg.norm(np.subtract(third.cart_offset_m, first.cart_offset_m))
        if not side[[0, 2]].any():
            raise wrong("links.l3c.platform_point_m", "must not lie on the line through 3a's along y: nothing holds ry")
        if third.length_m is None and base > 0.0:
            raise wrong(
                "links.l3c.length_m", "is missing; it can be left out only when 3a and 3c have one cart_offset_m"
            )
        if third.length_m is not None and abs(third.length_m - first.length_m) > np.linalg.norm(side) + base:
            raise wrong(
                "links.l3c.length_m",
                f"is {third.length_m:g}, which cannot close the triangle with link 3a ({first.length_m:g} m) and "
                f"the platform side ({np.linalg.norm(side):g} m)",
            )
        return self
