"""Limits of motion and force: of actuators, links and the TCP."""

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import Discriminator, Field, Tag

from pipeline.config.section import Section

PositiveForce = Annotated[float, Field(gt=0.0, le=1_000_000.0)]


class PushPullConfig(Section):
    """A force limit that depends on the sign of the force.

    Carts are pushed along +X and pulled along -X. A telescope or link that pushes is compressed and drives the platform
    away from its cart; one that pulls is in tension.
    """

    on_one_line: ClassVar[bool] = True

    push: PositiveForce = Field(description="carts: along +X; telescopes and links: in compression (extending)")
    pull: PositiveForce = Field(description="carts: along -X; telescopes and links: in tension (retracting)")


def _how_given(value: object) -> str:
    return PushPullConfig.__name__ if isinstance(value, Mapping | PushPullConfig) else "number"


ForceLimit = Annotated[
    Annotated[PositiveForce, Tag("number")] | Annotated[PushPullConfig, Tag(PushPullConfig.__name__)],
    Discriminator(_how_given),
]
"""One number for both signs, or push and pull. In errors, the name of the choice follows that of the key."""


def push_and_pull(limit: float | PushPullConfig | None) -> tuple[float, float]:
    """Return the largest positive and the largest negative force, in newtons; infinite where there is no limit."""
    if isinstance(limit, PushPullConfig):
        return limit.push, limit.pull
    return (np.inf, np.inf) if limit is None else (limit, limit)


class ActuatorLimitsConfig(Section):
    """Limits of an actuator; a velocity of zero locks it."""

    on_one_line: ClassVar[bool] = True

    velocity_mps: float = Field(ge=0.0, le=20.0)
    acceleration_mps2: float = Field(gt=0.0, le=500.0)
    jerk_mps3: float | None = Field(None, gt=0.0, le=100_000.0, description="null: not limited")
    force_n: ForceLimit | None = Field(
        None, description="peak force of the drive, or {push: ..., pull: ...}; null: not limited"
    )


class CartLimitsConfig(Section):
    """Limits of every cart by itself."""

    c1: ActuatorLimitsConfig = Field(description="cart of arm 1")
    c2: ActuatorLimitsConfig = Field(description="cart of arm 2")
    c3: ActuatorLimitsConfig = Field(description="cart of arm 3")


class TelescopeLimitsConfig(Section):
    """Limits of both telescopes by themselves."""

    l2b: ActuatorLimitsConfig = Field(description="telescopic link 2b")
    l3b: ActuatorLimitsConfig = Field(description="telescopic link 3b")


_DRIVES = {*CartLimitsConfig.model_fields, *TelescopeLimitsConfig.model_fields}


def _of_all(value: object) -> bool:
    """Check whether limits are given for all drives of a kind alike; the name of any drive says that they are not."""
    if isinstance(value, Mapping):
        others = [item for key, item in value.items() if key not in ActuatorLimitsConfig.model_fields]
        return _DRIVES.isdisjoint(value) and not any(isinstance(item, Mapping) for item in others)
    return not isinstance(value, CartLimitsConfig | TelescopeLimitsConfig)


_ALL = Annotated[ActuatorLimitsConfig, Tag(ActuatorLimitsConfig.__name__)]
CartLimits = Annotated[
    _ALL | Annotated[CartLimitsConfig, Tag(CartLimitsConfig.__name__)],
    Discriminator(lambda value: (ActuatorLimitsConfig if _of_all(value) else CartLimitsConfig).__name__),
]
TelescopeLimits = Annotated[
    _ALL | Annotated[TelescopeLimitsConfig, Tag(TelescopeLimitsConfig.__name__)],
    Discriminator(lambda value: (ActuatorLimitsConfig if _of_all(value) else TelescopeLimitsConfig).__name__),
]


class TcpLimitsConfig(Section):
    """Limits of the tool centre point, in any direction."""

    on_one_line: ClassVar[bool] = True

    speed_mps: float | None = Field(None, gt=0.0, le=20.0, description="null: not limited")
    acceleration_mps2: float | None = Field(None, gt=0.0, le=500.0, description="null: not limited")


class LimitsConfig(Section):
    """Limits of the five actuators, of the links and of the TCP; null: not limited."""

    carts: CartLimits = Field(
        description="of each cart, or a section for each (c1, c2, c3); force_n: a number, or {push: ..., pull: ...}"
    )
    telescopes: TelescopeLimits = Field(description="of each telescope, or a section for each (l2b, l3b)")
    link_force_n: ForceLimit | None = Field(
        None, description="axial force in any link, or {push: ..., pull: ...}; null: not limited"
    )
    holding_fraction: float = Field(
        1.0, gt=0.0, le=1.0, description="part of the force limits that holding the machine may take"
    )
    gravity_stiffness_npm: float | None = Field(
        None,
        lt=0.0,
        ge=-1e9,
        description="least stiffness that gravity may give the drives, in any direction; null: not limited",
    )
    tcp: TcpLimitsConfig = Field(default_factory=lambda: TcpLimitsConfig())

    def of_actuators(self) -> tuple[ActuatorLimitsConfig, ...]:
        """Return the limits of c1, c2, c3, l2b and l3b."""
        carts, telescopes = self.carts, self.telescopes
        return (
            *((carts.c1, carts.c2, carts.c3) if isinstance(carts, CartLimitsConfig) else (carts,) * 3),
            *((telescopes.l2b, telescopes.l3b) if isinstance(telescopes, TelescopeLimitsConfig) else (telescopes,) * 2),
        )

    def of_forces(self) -> list[str]:
        """Keys, within this section, of the limits of forces and of their derivatives that are given."""
        given = {f"{key}.force_n": limits.force_n for key, limits in self._sections().items()}
        given |= {key: getattr(self, key) for key in ("link_force_n", "gravity_stiffness_npm")}
        return [key for key, limit in given.items() if limit is not None]

    def holding(self) -> dict[str, Any]:
        """Give the keys that say what holding the machine may take."""

        def forces(given: Section) -> Any:
            single = isinstance(given, ActuatorLimitsConfig)
            return {"force_n"} if single else {name: {"force_n"} for name in type(given).model_fields}

        drives = {"carts": forces(self.carts), "telescopes": forces(self.telescopes)}
        include = {**drives, "link_force_n": True, "holding_fraction": True}
        if self.gravity_stiffness_npm is not None:
            include["gravity_stiffness_npm"] = True
        return self.model_dump(mode="json", include=include)

    def _sections(self) -> dict[str, ActuatorLimitsConfig]:
        """Limits of actuators, by the keys within this section under which they are given."""
        found = {}
        for kind, given in (("carts", self.carts), ("telescopes", self.telescopes)):
            if isinstance(given, ActuatorLimitsConfig):
                found[kind] = given
            else:
                found |= {f"{kind}.{name}": getattr(given, name) for name in type(given).model_fields}
        return found

    def with_forces(self, factor: float) -> Self:
        """Give limits whose forces are all multiplied by a factor."""

        def times(limit: float | PushPullConfig | None) -> float | PushPullConfig | None:
            if isinstance(limit, PushPullConfig):
                return limit.model_copy(update={"push": factor * limit.push, "pull": factor * limit.pull})
            return None if limit is None else factor * limit

        def drives(given: Section) -> Section:
            if isinstance(given, ActuatorLimitsConfig):
                return given.model_copy(update={"force_n": times(given.force_n)})
            return given.model_copy(update={name: drives(getattr(given, name)) for name in type(given).model_fields})

        changed = {"carts": drives(self.carts), "telescopes": drives(self.telescopes)}
        return self.model_copy(update={**changed, "link_force_n": times(self.link_force_n)})
