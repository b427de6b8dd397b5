"""The machine: rails, links, triangle, clearances, limits and masses."""

from typing import Annotated, ClassVar, Self

import numpy as np
from pydantic import Field, model_validator

from pipeline.config.choices import TriangleBranch
from pipeline.config.section import Interval, Length, PositiveLength, Section, Vector, require_ordered, wrong

Inertia = Annotated[float, Field(gt=0.0, le=10_000.0)]


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


class ActuatorLimitsConfig(Section):
    """Limits of each actuator of a kind; a velocity of zero locks it."""

    on_one_line: ClassVar[bool] = True

    velocity_mps: float = Field(ge=0.0, le=20.0)
    acceleration_mps2: float = Field(gt=0.0, le=500.0)
    jerk_mps3: float | None = Field(None, gt=0.0, le=100_000.0, description="null: not limited")
    force_n: float | None = Field(
        None, gt=0.0, le=1_000_000.0, description="peak force of the drive; null: not limited"
    )


class TcpLimitsConfig(Section):
    """Limits of the tool centre point, in any direction."""

    on_one_line: ClassVar[bool] = True

    speed_mps: float | None = Field(None, gt=0.0, le=20.0, description="null: not limited")
    acceleration_mps2: float | None = Field(None, gt=0.0, le=500.0, description="null: not limited")


class LimitsConfig(Section):
    """Limits of the five actuators, of the links and of the TCP; null: not limited."""

    carts: ActuatorLimitsConfig
    telescopes: ActuatorLimitsConfig
    link_force_n: float | None = Field(
        None, gt=0.0, le=1_000_000.0, description="axial force in any link, pushed or pulled; null: not limited"
    )
    holding_fraction: float = Field(
        1.0, gt=0.0, le=1.0, description="part of the force limits that holding the machine may take"
    )
    tcp: TcpLimitsConfig = Field(default_factory=lambda: TcpLimitsConfig())

    def of_forces(self) -> list[str]:
        """Keys, within this section, of the force limits that are given."""
        given = {
            "carts.force_n": self.carts.force_n,
            "telescopes.force_n": self.telescopes.force_n,
            "link_force_n": self.link_force_n,
        }
        return [key for key, limit in given.items() if limit is not None]

    def with_forces(self, factor: float) -> Self:
        """Give limits whose forces are all multiplied by a factor."""

        def times(limit: float | None) -> float | None:
            return None if limit is None else factor * limit

        drives = {
            key: kind.model_copy(update={"force_n": times(kind.force_n)})
            for key, kind in (("carts", self.carts), ("telescopes", self.telescopes))
        }
        return self.model_copy(update={**drives, "link_force_n": times(self.link_force_n)})


class ClearanceConfig(Section):
    """Least distances between axes (link diameter plus margin)."""

    link_link_m: float = Field(ge=0.0, le=1.0, description="between any two links that share no joint")
    link_rail_m: float | None = Field(
        None, ge=0.0, le=1.0, description="between a link and another arm's rail; null: not checked"
    )


class PlatformMassConfig(Section):
    """Platform and tool, a rigid body: centre from the TCP, principal moments about it."""

    on_one_line: ClassVar[bool] = True

    mass_kg: float = Field(gt=0.0, le=10_000.0)
    centre_of_mass_m: Vector = Field((0.0, 0.0, 0.0), description="in the platform frame, from the TCP")
    inertia_kgm2: tuple[Inertia, Inertia, Inertia] = Field(
        description="principal moments about the centre of mass, along the axes of the platform frame"
    )

    @model_validator(mode="after")
    def _is_of_a_body(self) -> Self:
        if 2.0 * max(self.inertia_kgm2) > sum(self.inertia_kgm2) * (1.0 + 1e-9):
            raise wrong(
                "inertia_kgm2", f"is {list(self.inertia_kgm2)}; allowed is none larger than the sum of the other two"
            )
        return self


class FrictionConfig(Section):
    """Dry friction of the drives, always against the motion."""

    on_one_line: ClassVar[bool] = True

    carts_n: float = Field(0.0, ge=0.0, le=100_000.0)
    telescopes_n: float = Field(0.0, ge=0.0, le=100_000.0)


class DynamicsConfig(Section):
    """Masses, from which forces follow; those of links and telescopes are taken half to each end."""

    cart_mass_kg: float = Field(gt=0.0, le=10_000.0, description="of each cart")
    link_mass_kg: float = Field(ge=0.0, le=1_000.0, description="of each link of fixed length")
    telescope_mass_kg: float = Field(ge=0.0, le=1_000.0, description="of each telescope")
    platform: PlatformMassConfig
    load_kg: float = Field(0.0, ge=0.0, le=10_000.0, description="mass of a load at the TCP")
    gravity_mps2: float = Field(9.81, ge=0.0, le=30.0, description="against Z")
    friction: FrictionConfig = Field(default_factory=lambda: FrictionConfig())


class MachineConfig(Section):
    """The machine: everything its kinematics, clearances and limits depend on."""

    rails: tuple[RailConfig, RailConfig, RailConfig] = Field(
        description="of arms 1, 2, 3, along X: where they are, and the travel of their carts"
    )
    links: LinksConfig
    triangle_branch: TriangleBranch = Field(
        TriangleBranch.NEGATIVE, description="sign of y_platform . (w x u_3c) that the assembled machine keeps"
    )
    clearance: ClearanceConfig
    limits: LimitsConfig
    dynamics: DynamicsConfig | None = Field(
        None, description="masses, for forces and their limits; null: no forces, and no limits of forces either"
    )

    def holding(self) -> dict[str, object]:
        """Give the keys that holding forces and their limits follow from; none if no forces are limited."""
        if self.dynamics is None or not self.limits.of_forces():
            return {}
        limits = self.limits
        return {
            "limits": {
                "carts": limits.carts.model_dump(mode="json", include={"force_n"}),
                "telescopes": limits.telescopes.model_dump(mode="json", include={"force_n"}),
                **limits.model_dump(mode="json", include={"link_force_n", "holding_fraction"}),
            },
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
