"""The drives of the machine and their controllers, for its simulation under feedback; all defaults are assumed."""

from collections.abc import Callable, Mapping
from typing import Annotated, Any, ClassVar

from pydantic import Discriminator, Field, Tag

from pipeline.config.machine.limits import ForceLimit
from pipeline.config.section import Section

Share = Annotated[float, Field(ge=0.0, le=1.0)]
Gain = Annotated[float, Field(gt=0.0, le=100_000_000.0)]


class FeedForwardConfig(Section):
    """Which part of what the motion takes is commanded without waiting for an error, 0 to 1 each."""

    on_one_line: ClassVar[bool] = True

    velocity: Share = Field(1.0, description="of the velocity")
    force: Share = Field(1.0, description="of the force without friction, from the model")
    friction: Share = Field(0.0, description="of dry and viscous friction")


class CartDriveConfig(Section):
    """Drive and controller of a cart: P over the position, PI over the velocity."""

    position_gain_per_s: float = Field(10.0, gt=0.0, le=10_000.0, description="velocity per following error; assumed")
    velocity_gain_nspm: Gain = Field(8_000.0, description="force per velocity error; assumed")
    integral_time_s: float | None = Field(
        0.3, gt=0.0, le=1_000.0, description="of the velocity's integral; assumed; null: no integral"
    )
    feed_forward: FeedForwardConfig = Field(
        default_factory=lambda: FeedForwardConfig(),
        description="part of velocity, force (from the model) and friction that is commanded beforehand; assumed",
    )
    dry_friction_n: float | None = Field(
        None,
        ge=0.0,
        le=100_000.0,
        description="null: that of machine.dynamics.friction or, where that is 0, 20 for carts and 40 for telescopes, "
        "assumed",
    )
    viscous_friction_nspm: float = Field(30.0, ge=0.0, le=1_000_000.0, description="assumed")
    moving_mass_kg: float = Field(
        3.0, ge=0.0, le=10_000.0, description="of motor and gear, beside machine.dynamics; assumed"
    )
    saturation_n: ForceLimit | None = Field(
        None, description="largest force, or {push: ..., pull: ...}; null: the limit in machine.limits"
    )
    encoder_step_m: float = Field(1e-6, ge=0.0, le=0.01, description="0: position and velocity are exact; assumed")
    force_lag_s: float = Field(0.0, ge=0.0, le=1.0, description="time constant from commanded to real force; assumed")
    delay_s: float = Field(
        0.0, ge=0.0, le=1.0, description="from measuring to force, to the nearest whole period; assumed"
    )
    following_error_trip_m: float = Field(
        0.02, gt=0.0, le=10.0, description="following error at which the drive switches off; assumed"
    )


class TelescopeDriveConfig(CartDriveConfig):
    """Drive and controller of a telescope, as of a cart, with other figures assumed."""

    velocity_gain_nspm: Gain = Field(5_000.0, description="force per velocity error; assumed")
    viscous_friction_nspm: float = Field(100.0, ge=0.0, le=1_000_000.0, description="assumed")
    moving_mass_kg: float = Field(
        5.0, ge=0.0, le=10_000.0, description="of motor and gear, beside machine.dynamics; assumed"
    )


class CartDrivesConfig(Section):
    """The drive of every cart by itself."""

    c1: CartDriveConfig = Field(default_factory=lambda: CartDriveConfig(), description="cart of arm 1")
    c2: CartDriveConfig = Field(default_factory=lambda: CartDriveConfig(), description="cart of arm 2")
    c3: CartDriveConfig = Field(default_factory=lambda: CartDriveConfig(), description="cart of arm 3")


class TelescopeDrivesConfig(Section):
    """The drives of both telescopes by themselves."""

    l2b: TelescopeDriveConfig = Field(default_factory=lambda: TelescopeDriveConfig(), description="telescopic link 2b")
    l3b: TelescopeDriveConfig = Field(default_factory=lambda: TelescopeDriveConfig(), description="telescopic link 3b")


_NAMES = {*CartDrivesConfig.model_fields, *TelescopeDrivesConfig.model_fields}


def _kind(of_all: type[Section], single: type[Section]) -> Callable[[object], str]:
    """Tell a section for all drives of a kind from one that names them; the name of any drive says which."""

    def name(value: object) -> str:
        named = isinstance(value, single)
        if isinstance(value, Mapping):
            others = {key: item for key, item in value.items() if key not in of_all.model_fields}
            named = not _NAMES.isdisjoint(others) or any(isinstance(item, Mapping) for item in others.values())
        return (single if named else of_all).__name__

    return name


CartDrives = Annotated[
    Annotated[CartDriveConfig, Tag(CartDriveConfig.__name__)]
    | Annotated[CartDrivesConfig, Tag(CartDrivesConfig.__name__)],
    Discriminator(_kind(CartDriveConfig, CartDrivesConfig)),
]
TelescopeDrives = Annotated[
    Annotated[TelescopeDriveConfig, Tag(TelescopeDriveConfig.__name__)]
    | Annotated[TelescopeDrivesConfig, Tag(TelescopeDrivesConfig.__name__)],
    Discriminator(_kind(TelescopeDriveConfig, TelescopeDrivesConfig)),
]


class DrivesConfig(Section):
    """Drives and their controllers, which only `simulate` and `tune` read; all defaults are assumed."""

    carts: CartDrives = Field(
        default_factory=lambda: CartDriveConfig(),
        description="of each cart, or a section for each (c1, c2, c3)",
    )
    telescopes: TelescopeDrives = Field(
        default_factory=lambda: TelescopeDriveConfig(),
        description="of each telescope, or a section for each (l2b, l3b)",
    )

    def of_actuators(self) -> tuple[CartDriveConfig, ...]:
        """Return the drives of c1, c2, c3, l2b and l3b."""
        carts, telescopes = self.carts, self.telescopes
        return (
            *((carts.c1, carts.c2, carts.c3) if isinstance(carts, CartDrivesConfig) else (carts,) * 3),
            *((telescopes.l2b, telescopes.l3b) if isinstance(telescopes, TelescopeDrivesConfig) else (telescopes,) * 2),
        )

    def with_gains(self, carts: Mapping[str, float], telescopes: Mapping[str, float]) -> dict[str, Any]:
        """Give what differs from the defaults, with other gains for all carts and for all telescopes, as plain data."""
        data: dict[str, Any] = {}
        for key, section, gains in (("carts", self.carts, carts), ("telescopes", self.telescopes, telescopes)):
            given = section.model_dump(mode="json", exclude_defaults=True)
            single = isinstance(section, CartDriveConfig)
            names = {} if single else type(section).model_fields
            data[key] = {**given, **gains} if single else {name: {**given.get(name, {}), **gains} for name in names}
        return data
