"""Masses of the machine, from which forces follow."""

from typing import Annotated, ClassVar, Self

from pydantic import Field, model_validator

from pipeline.config.section import Section, Vector, wrong

Inertia = Annotated[float, Field(gt=0.0, le=10_000.0)]


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
