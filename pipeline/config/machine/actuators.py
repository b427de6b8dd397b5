"""What the controller's positions of actuators are in the geometry of the machine."""

from typing import ClassVar

from pydantic import Field

from pipeline.config.section import Section


class ActuatorConfig(Section):
    """What a controller's position q of an actuator is: middle + zero_m + scale (q - middle), middle of its range."""

    on_one_line: ClassVar[bool] = True

    zero_m: float = Field(0.0, ge=-0.1, le=0.1)
    scale: float = Field(1.0, ge=0.9, le=1.1)


class ActuatorsConfig(Section):
    """Zero and scale of every actuator, as a calibration finds them; files for controllers are written with them."""

    c1: ActuatorConfig = Field(default_factory=lambda: ActuatorConfig(), description="cart of arm 1")
    c2: ActuatorConfig = Field(default_factory=lambda: ActuatorConfig(), description="cart of arm 2")
    c3: ActuatorConfig = Field(default_factory=lambda: ActuatorConfig(), description="cart of arm 3")
    l2b: ActuatorConfig = Field(default_factory=lambda: ActuatorConfig(), description="telescopic link 2b")
    l3b: ActuatorConfig = Field(default_factory=lambda: ActuatorConfig(), description="telescopic link 3b")

    def in_order(self) -> tuple[ActuatorConfig, ...]:
        """Return those of c1, c2, c3, l2b and l3b."""
        return self.c1, self.c2, self.c3, self.l2b, self.l3b
