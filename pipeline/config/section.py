"""What every section of the configuration is: immutable, strict, with bounds that catch a wrong unit."""

from typing import Annotated, ClassVar, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationInfo, field_validator
from pydantic_core import PydanticCustomError

MODE_PATTERN = "^[LR]{3}$"
NAME_PATTERN = r"^(\w[\w.-]*)?$"
MOST_NAME = 60
"""Longest name, in characters: with up to four bytes each, a folder can still be named after it."""

# Bounds that no Gantry-Tau exceeds: they are there to catch a value given in the wrong unit.
Length = Annotated[float, Field(ge=-20.0, le=20.0)]
PositiveLength = Annotated[float, Field(gt=0.0, le=20.0)]
Tilt = Annotated[float, Field(ge=-85.0, le=85.0)]
Vector = tuple[Length, Length, Length]
Interval = tuple[Length, Length]


class Section(BaseModel):
    """A part of the configuration: immutable, unknown keys refused, no NaN and no infinity."""

    on_one_line: ClassVar[bool] = False
    """Whether the section is written on one line where all keys are listed: its keys explain themselves."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    @field_validator("*", mode="before")
    @classmethod
    def _truth_values_in_their_place(cls, value: object, info: ValidationInfo) -> object:
        # Where a key is no switch, pydantic takes `yes` for the number 1; where it is one, the number 1 for `on`.
        is_switch = info.field_name is not None and cls.model_fields[info.field_name].annotation is bool
        if is_switch and not isinstance(value, bool):
            raise PydanticCustomError("switch", "only on and off are values here")
        if not is_switch and any(isinstance(item, bool) for item in (value if isinstance(value, list) else [value])):
            raise PydanticCustomError("truth_value", "true and false are no values here")
        return value


S = TypeVar("S", bound=Section)


def require_ordered(section: S, key: str, interval: tuple[float, float]) -> S:
    """Refuse an interval whose ends are not in order; `key` is the one to look at."""
    if interval[0] >= interval[1]:
        raise wrong(key, f"is {list(interval)}; allowed is [least, largest] with least below largest")
    return section


def wrong(key: str, message: str) -> PydanticCustomError:
    """Make the error of a rule that involves several keys; `key` is the one to look at, from the section on."""
    return PydanticCustomError("rule", "{key} {message}", {"key": key, "message": message})
