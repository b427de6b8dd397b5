"""A calibration as it was written beside a calibrated configuration, and whether a machine is the one that it found."""

import json
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from pipeline.arrays import BoolArray, FloatArray
from pipeline.calibrate.model import parameters as kinds
from pipeline.calibrate.model.model import Model, configured_model
from pipeline.calibrate.model.parameters import Kind, Parameters
from pipeline.config import MachineConfig
from pipeline.errors import UsageError
from pipeline.regular_file import read_regular_file

_MOST_BYTES = 10_000_000
_MOST_PARAMETERS, _MOST_REFLECTORS = 200, 3
_SAME = 2e-9
"""How far a machine may be from the calibrated one: a configuration has nanometres."""
_ADVICE = "\n  What to change: give the file .json that gantry-tau calibrate wrote beside its --output."
_Three = Annotated[list[float], Field(min_length=3, max_length=3)]


class _Part(BaseModel):
    model_config = ConfigDict(strict=True, extra="ignore", allow_inf_nan=False, frozen=True)


class _Parameter(_Part):
    name: str
    configured: float
    change: float
    prior_std: float | None
    source: str


class _Tracker(_Part):
    rotation: Annotated[list[_Three], Field(min_length=3, max_length=3)]
    translation_m: _Three


class _Setting(_Part):
    fit: list[str]
    reflectors_m: Annotated[list[_Three], Field(min_length=1, max_length=_MOST_REFLECTORS)]


class _Shape(_Part):
    accepted: bool
    setting: _Setting
    tracker: _Tracker
    parameters: Annotated[list[_Parameter], Field(max_length=_MOST_PARAMETERS)]
    covariance: Annotated[list[list[float]], Field(max_length=_MOST_PARAMETERS)]


@dataclass(frozen=True, eq=False)
class StoredCalibration:
    """What a calibration's file says of the machine.

    Attributes
    ----------
    content : bytes
        The file.
    parameters : Parameters
        The parameters, in order.
    values : (count,)
        What was found of them.
    covariance : (count, count)
        Of all parameters; zero for those that were not fitted.
    prior_std : (count,)
        Standard deviations of what was known beforehand; infinite for the tracker's frame.
    is_fitted : (count,)
        Parameters that were fitted.
    tracker_rotation : (3, 3)
        Orientation of the machine's frame in the tracker's.
    """

    content: bytes
    parameters: Parameters
    values: FloatArray
    covariance: FloatArray
    prior_std: FloatArray
    is_fitted: BoolArray
    tracker_rotation: FloatArray

    @property
    def sha256(self) -> str:
        """Hash of the file."""
        return sha256(self.content).hexdigest()

    def of(self, kind: Kind) -> FloatArray:
        """Give what was found of a kind."""
        return self.parameters.of(kind, self.values)


def read_calibration(file: Path) -> StoredCalibration:
    """Read the file of a calibration.

    Raises
    ------
    UsageError
        When it cannot be read, is not of a calibration, or of one that was not accepted.
    """
    try:
        content = read_regular_file(file, _MOST_BYTES)
    except OSError as error:
        raise UsageError(f"{file} cannot be read: {error.strerror or error}.{_ADVICE}") from None
    return parse_calibration(content, str(file))


def parse_calibration(content: bytes, source: str) -> StoredCalibration:
    """Read the content of a calibration's file; raises what `read_calibration` does."""
    try:
        shape = _Shape.model_validate(json.loads(content))
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(map(str, first["loc"])) or "the whole"
        raise UsageError(f"{source} is not the file of a calibration: {where}: {first['msg']}.{_ADVICE}") from None
    except (ValueError, RecursionError):
        raise UsageError(f"{source} is not the file of a calibration: it is not JSON.{_ADVICE}") from None
    names, covariance = tuple(one.name for one in shape.parameters), [tuple(row) for row in shape.covariance]
    parameters = Parameters(len(shape.setting.reflectors_m), sum(name.startswith(kinds.CLOCK) for name in names))
    if names != parameters.names or {len(row) for row in covariance} != {len(names)} or len(covariance) != len(names):
        raise UsageError(
            f"{source} has other parameters than a machine with {len(shape.setting.reflectors_m)} reflectors, or a "
            f"covariance of another size.{_ADVICE}"
        )
    if not shape.accepted:
        raise UsageError(
            f"{source} is of a calibration that was not accepted.\n  What to change: calibrate again; it says why not."
        )
    prior = np.array([np.inf if one.prior_std is None else one.prior_std for one in shape.parameters])
    S = np.array(covariance)
    if not (S == S.T).all() and np.abs(S - S.T).max() > 1e-9 * np.abs(S).max():
        raise UsageError(f"{source} has a covariance that is not symmetric.{_ADVICE}")
    return StoredCalibration(
        content=content,
        parameters=parameters,
        values=np.array([one.configured + one.change for one in shape.parameters]),
        covariance=(S + S.T) / 2.0,
        prior_std=prior,
        is_fitted=parameters.is_fitted(tuple(shape.setting.fit)),
        tracker_rotation=np.array(shape.tracker.rotation),
    )


def require_calibrated(stored: StoredCalibration, machine: MachineConfig) -> Model:
    """Require that a machine is the calibrated one, and give it with the reflectors as they were found.

    Raises
    ------
    UsageError
        When it is another machine, or has rails that are not along X or whose directions were fitted.
    """
    parameters = stored.parameters
    if np.abs(stored.covariance[parameters.slice(kinds.DIRECTIONS)]).max() > 0.0 or stored.of(kinds.DIRECTIONS).any():
        raise UsageError(
            "directions of rails were fitted, or rails have slopes; machines around a calibration are proven only "
            "with rails along X.\n"
            "  What to change: calibrate without directions in --fit, if that is accepted, or align the rails."
        )
    if any(any(rail.slopes) for rail in machine.rails):
        raise UsageError(
            "rails of this machine are off X (machine.rails.slopes); machines are proven with parallel ones.\n"
            "  What to change: leave out the slopes, and calibrate without directions in --fit."
        )
    # Clocks of measured motions are nothing of the machine, but among the parameters.
    model = configured_model(machine, stored.of(kinds.REFLECTORS).reshape(-1, 3)).with_clocks(stored.of(kinds.CLOCKS))
    end = parameters.slice(kinds.REFLECTORS).start
    off = np.abs(model.values() - stored.values)[:end]
    if (off > _SAME).any():
        worst = int(np.argmax(off))
        found = f"{parameters.names[worst]} is {model.values()[worst]:.9g}, calibrated {stored.values[worst]:.9g}"
        raise UsageError(
            f"this machine is not the calibrated one: {found} ({np.count_nonzero(off > _SAME)} of {end} parameters "
            "differ).\n  What to change: plan with the configuration that calibrate wrote (--output), and give its run."
        )
    return model.with_frame(stored.tracker_rotation, model.translation_m)
