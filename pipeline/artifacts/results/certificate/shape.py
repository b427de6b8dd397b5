"""The shape of a certificate file: its keys, and the values allowed for each."""

import json
from collections.abc import Iterable
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, FailFast, Field, create_model, model_validator
from pydantic_core import ErrorDetails, PydanticCustomError

from pipeline.config.messages import key_path
from pipeline.inclusion.calibrated.ellipsoid import PARAMETERS
from pipeline.limits import CertificateKey, Side

FORMAT = 3
"""Version of the file format, increased when its meaning changes."""
_MOST_CHAINS = 24
"""More than a certificate has: each takes a while to be refused."""


def _whole(value: object) -> object:
    """Let a whole number pass, but not what Python has equal to one: 1.0 and true."""
    if type(value) is not int:
        raise PydanticCustomError("whole", "expected a whole number")
    return value


_Number = Annotated[float, Field(ge=0.0)]
_PartOfPath = Annotated[float, Field(ge=0.0, le=1.0)]
_Count = Annotated[int, Field(ge=0)]
_Six = Annotated[list[float], FailFast(), Field(min_length=6, max_length=6)]
_Radius = Annotated[list[_Number], FailFast(), Field(min_length=6, max_length=6)]
_Cubic = Annotated[list[_Six], FailFast(), Field(min_length=4, max_length=4)]
_Five = Annotated[list[float], Field(min_length=5, max_length=5)]
_Positive = Annotated[float, Field(gt=0.0)]
_Row = Annotated[list[float], FailFast(), Field(min_length=1, max_length=PARAMETERS)]
_Range = Annotated[list[float], Field(min_length=2, max_length=2)]
_Hash = Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]


class _Part(BaseModel):
    """A section: every number is finite, no key is unknown, and nothing is converted."""

    model_config = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False, frozen=True)


class EllipsoidShape(_Part):
    """The machines that a calibration leaves possible: a row of the factor for each parameter."""

    factor: Annotated[list[_Row], FailFast(), Field(min_length=PARAMETERS, max_length=PARAMETERS)]
    sigma: _Positive
    zero_at_m: _Five
    scale: Annotated[list[_Positive], Field(min_length=5, max_length=5)]

    @model_validator(mode="after")
    def _rows_agree(self) -> Self:
        if len({len(row) for row in self.factor}) != 1:
            raise _wrong("factor", "has rows of different lengths")
        return self


class UncertaintyShape(_Part):
    """The uncertainty of the machine of a chain."""

    length_m: _Number
    coordinate_m: _Number
    actuator_m: Annotated[list[_Number], Field(min_length=5, max_length=5)] = [0.0] * 5
    ellipsoid: EllipsoidShape | None = None

    @model_validator(mode="after")
    def _one_kind(self) -> Self:
        if self.ellipsoid is not None and any((self.length_m, self.coordinate_m, *self.actuator_m)):
            raise _wrong("ellipsoid", "is beside other errors")
        return self


class ChainShape(_Part):
    """A chain: n boxes between n + 1 values of s, with a joint at each.

    The first fault of a list is enough: a damaged file may have a million.
    """

    uncertainty: UncertaintyShape
    s: Annotated[list[_PartOfPath], FailFast(), Field(min_length=2)]
    pose: Annotated[list[_Cubic], FailFast()]
    radius: Annotated[list[_Radius], FailFast()]
    joint_pose: Annotated[list[_Six], FailFast()]
    joint_radius: Annotated[list[_Radius], FailFast()]
    within_limits: bool = False
    profile_m: list[_Number] | None = None

    @model_validator(mode="after")
    def _lengths_agree(self) -> Self:
        joints = len(self.s)
        wanted = {"pose": joints - 1, "radius": joints - 1, "joint_pose": joints, "joint_radius": joints}
        if self.profile_m is not None:
            wanted["profile_m"] = joints - 1
        for key, count in wanted.items():
            if (found := len(getattr(self, key))) != count:
                raise _wrong(key, f"has {found} entries; {joints} values of s need {count}")
        return self


class BoundsShape(_Part):
    """What is proven for every s, apart from the bounds of limits."""

    kappa_s: _PartOfPath
    start_miss: _Number
    goal_miss: _Number


class ToleranceShape(_Part):
    """A tolerance and how it was found."""

    proven_m: _Number
    not_proven_m: _Number | None
    monte_carlo_fails_m: _Number | None
    boxes: _Count
    tilt_reserve_deg: Annotated[list[_Number] | None, Field(min_length=2, max_length=2)] = None
    stopped_by: str | None = None
    stopped_at_s: _PartOfPath | None = None


class CalibratedShape(ToleranceShape):
    """A tolerance of following errors beside calibration errors."""

    length_m: _Number
    coordinate_m: _Number


class MachinesShape(_Part):
    """What is proven of all machines that a calibration leaves possible."""

    sigma: _Positive
    dimensions: _Count
    probability: _PartOfPath
    boxes: _Count
    within_limits: bool
    calibration_sha256: _Hash
    parameters: Annotated[list[str], Field(min_length=PARAMETERS, max_length=PARAMETERS)]
    tilt_reserve_deg: Annotated[list[_Number], Field(min_length=2, max_length=2)]
    actuator_reserve_m: Annotated[list[_Number], Field(min_length=5, max_length=5)]
    ranges_kept: bool


class TolerancesShape(_Part):
    """Both calibration tolerances, and those of following errors: within limits, and merely on the branch."""

    link_length: ToleranceShape | None
    coordinates: ToleranceShape | None
    following_within_limits: dict[str, ToleranceShape] = {}
    following_on_branch: dict[str, ToleranceShape] = {}
    following_calibrated: CalibratedShape | None = None
    machines: MachinesShape | None = None


class CertificateShape(_Part):
    """The whole file; `settings`, `versions` and `seconds` say how it was made."""

    format: Annotated[Literal[3], BeforeValidator(_whole)]
    verdict: Literal["certified"]
    refused_at_s: None
    refused_because: None
    boxes: _Count
    path_sha256: _Hash
    premises_sha256: _Hash
    bounds: BoundsShape
    tolerance_m: _Number | None
    coordinates_tolerance_m: _Number | None
    tolerances: TolerancesShape
    precision_bits: _Count
    settings: dict[str, Any] = {}
    versions: dict[str, str] = {}
    seconds: _Number = 0.0
    chains: Annotated[list[ChainShape], Field(max_length=_MOST_CHAINS)]

    @model_validator(mode="after")
    def _tolerances_agree(self) -> Self:
        for key, tolerance in (
            ("tolerance_m", self.tolerances.link_length),
            ("coordinates_tolerance_m", self.tolerances.coordinates),
        ):
            within = None if tolerance is None else tolerance.proven_m
            if (stated := getattr(self, key)) != within:
                raise _wrong(key, f"is {_shown(stated)}, but proven_m within tolerances is {_shown(within)}")
        return self


def certificate_shape(keys: Iterable[CertificateKey]) -> type[CertificateShape]:
    """Return the shape of a certificate that states the bounds of these keys, and no others."""
    fields: dict[str, Any] = {key.name: (_shape_of(key), None if key.optional else ...) for key in keys}
    bounds = create_model("BoundsShape", __base__=BoundsShape, **fields)
    return create_model("CertificateShape", __base__=CertificateShape, bounds=(bounds, ...))


def _shape_of(key: CertificateKey) -> Any:
    value = _VALUES[key.side]
    if key.subjects is None:
        return dict[str, value]  # type: ignore[valid-type]  # a type chosen at run time
    if not key.subjects:
        return value
    subjects: dict[str, Any] = dict.fromkeys(key.subjects, (value, ...))
    return create_model(key.name, __base__=_Part, **subjects)


def explain(error: ErrorDetails) -> str:
    """Turn an error of pydantic into a key's path, the value found and the value expected."""
    location, context = error["loc"], error.get("ctx", {})
    if error["type"] == "certificate":
        return f"{key_path((*location, context['key']))}: {context['message']}"
    if error["type"] in _WITHOUT_VALUE:
        return f"{key_path(location)}: {_WITHOUT_VALUE[error['type']]}"
    wanted = _WANTED.get(error["type"], "something else").format(**context)
    return f"{key_path(location)}: is {_shown(error['input'])}; expected {wanted}"


def _wrong(key: str, message: str) -> PydanticCustomError:
    return PydanticCustomError("certificate", "{key}: {message}", {"key": key, "message": message})


def _shown(value: object) -> str:
    """Show a value as JSON, lists and sections by their size only."""
    if isinstance(value, dict):
        return f"a section of {len(value)} keys"
    if isinstance(value, list):
        return f"a list of {len(value)} entries"
    text = json.dumps(value, default=str, ensure_ascii=False)
    return text if len(text) <= 40 else f"{text[:37]}..."


_VALUES: dict[Side, Any] = {
    Side.BOTH: _Range,
    Side.LARGEST: _Number,
    Side.LEAST: _Number,
    Side.FLOOR: float,
    Side.SIGN: Annotated[Literal[-1, 1], BeforeValidator(_whole)],
}
_WITHOUT_VALUE = {"missing": "is missing", "extra_forbidden": "is not a key of this format"}
_WANTED = {
    "float_type": "a number",
    "int_type": "a whole number",
    "string_type": "a text",
    "list_type": "a list",
    "dict_type": "a section",
    "model_type": "a section",
    "none_required": "null",
    "finite_number": "a finite number",
    "greater_than": "a number above {gt}",
    "greater_than_equal": "a number of at least {ge}",
    "less_than_equal": "a number of at most {le}",
    "literal_error": "{expected}",
    "whole": "a whole number",
    "string_pattern_mismatch": "64 hexadecimal digits",
    "too_short": "a list of at least {min_length} entries",
    "too_long": "a list of at most {max_length} entries",
}
