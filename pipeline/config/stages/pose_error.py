"""Errors of drives and geometry for which the error of the tool is proven."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from pipeline.config.section import Section, wrong

Error = Annotated[float, Field(ge=0.0, le=0.1)]


class PoseErrorConfig(Section):
    """Errors for which the error of the tool is proven, all along the path."""

    drives_m: tuple[Error, Error, Error, Error, Error] = Field(
        (0.0, 0.0, 0.0, 0.0, 0.0), description="how far c1, c2, c3, l2b, l3b may be off the path, at any time"
    )
    lengths_m: float = Field(0.0, ge=0.0, le=0.1, description="how wrong every link's length may be")
    coordinates_m: float = Field(
        0.0, ge=0.0, le=0.1, description="how wrong every coordinate of every joint and rail may be"
    )

    @model_validator(mode="after")
    def _something_is_off(self) -> Self:
        if not any((*self.drives_m, self.lengths_m, self.coordinates_m)):
            raise wrong("drives_m", "is 0, and so are lengths_m and coordinates_m; expected an error above 0, or null")
        return self
