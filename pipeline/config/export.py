"""Exports: how other programs name what moves."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from pipeline.config.section import Section, wrong

JOINT_PATTERN = r"^[A-Za-z_][\w/.-]*$"
JointName = Annotated[str, Field(pattern=JOINT_PATTERN, max_length=100)]


class ExportConfig(Section):
    """What trajectories are written as for other programs."""

    joint_names: tuple[JointName, JointName, JointName, JointName, JointName] = Field(
        ("c1", "c2", "c3", "l2b", "l3b"),
        description="names of carts 1 to 3 and telescopes 2b and 3b for the controller",
    )

    @model_validator(mode="after")
    def _names_differ(self) -> Self:
        if len(set(self.joint_names)) < len(self.joint_names):
            raise wrong("joint_names", f"is {list(self.joint_names)}; allowed are five different names")
        return self
