"""The certificate as a file: verdict and bounds first, then the boxes with which it can be verified again."""

import json
import pathlib
from collections.abc import Mapping
from dataclasses import asdict, fields, replace
from typing import Any

import numpy as np
from pydantic import ValidationError

from pipeline.artifacts.files import jsonable
from pipeline.artifacts.layout import CERTIFICATE_JSON
from pipeline.artifacts.results.certificate.bounds import read_bounds, state_bounds
from pipeline.artifacts.results.certificate.json_text import ADVICE, MOST_BOXES, read_certificate_json
from pipeline.artifacts.results.certificate.shape import (
    FORMAT,
    CalibratedShape,
    ChainShape,
    MachinesShape,
    ToleranceShape,
    UncertaintyShape,
    certificate_shape,
    explain,
)
from pipeline.artifacts.results.saved import SavedRun
from pipeline.certify.guess import point_box
from pipeline.certify.recheck import StatedCalibrated, StatedFollowing, StatedMachines, StatedTolerance, Statement
from pipeline.certify.result import NOT_CERTIFIED, Certificate, FollowingTolerances, ProvenChain, Tolerance
from pipeline.errors import UsageError
from pipeline.inclusion.calibrated.ellipsoid import Ellipsoid
from pipeline.inclusion.krawczyk import Box
from pipeline.inclusion.uncertainty import CERTAIN, Uncertainty
from pipeline.limits import certificate_keys

_SHOWN = 5
"""Number of faults reported: a damaged file may have thousands."""


def certificate_files(certificate: Certificate, facts: Mapping[str, Any]) -> dict[str, bytes]:
    """Write the certificate: its verdict and bounds, and the boxes with which it can be verified again."""
    return {CERTIFICATE_JSON: certificate_bytes(certificate, facts)}


def load_certificate(run: SavedRun) -> Statement:
    """Load what can be verified of the certificate of a run."""
    return read_certificate(run.folder / CERTIFICATE_JSON)


def certificate_bytes(certificate: Certificate, facts: Mapping[str, Any]) -> bytes:
    """Write a certificate: the facts a line each, every chain on one line."""
    return _text(certificate_dict(certificate, facts))


def with_machines(data: Mapping[str, Any], stated: StatedMachines, chain: ProvenChain) -> bytes:
    """Write a certificate as it was read, with what is proven of all machines that a calibration leaves possible."""
    others = [one for one in data["chains"] if "ellipsoid" not in one["uncertainty"]]
    tolerances = {**data["tolerances"], "machines": asdict(stated)}
    return _text({**data, "tolerances": tolerances, "chains": [*others, _chain_dict(chain)]})


def _text(data: Mapping[str, Any]) -> bytes:
    value = jsonable(data)
    proofs = ",\n    ".join(json.dumps(chain, allow_nan=False) for chain in value.pop("chains"))
    head = json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False).removesuffix("\n}")
    return f'{head},\n  "chains": [\n    {proofs}\n  ]\n}}\n'.encode()


def certificate_dict(certificate: Certificate, facts: Mapping[str, Any]) -> dict[str, Any]:
    """Arrange a certificate for its file; `facts` are the settings, versions and seconds, which it does not hold."""
    failure, link_length, coordinates = certificate.failure, certificate.link_length, certificate.coordinates
    return {
        "format": FORMAT,
        "verdict": certificate.verdict,
        "refused_at_s": None if failure is None else failure.s,
        "refused_because": None if failure is None else failure.reason.text,
        "boxes": len(certificate.chain.boxes),
        "path_sha256": certificate.path_sha256,
        "premises_sha256": certificate.premises_sha256,
        "bounds": None if certificate.bounds is None else state_bounds(certificate.bounds, certificate_keys()),
        "tolerance_m": None if link_length is None else link_length.eps_m,
        "coordinates_tolerance_m": None if coordinates is None else coordinates.eps_m,
        "tolerances": {
            "link_length": _tolerance_dict(link_length),
            "coordinates": _tolerance_dict(coordinates),
            **({} if certificate.following is None else _following_dict(certificate.following)),
        },
        "precision_bits": certificate.precision_bits,
        **facts,
        "chains": [_chain_dict(chain) for chain in chains(certificate)],
    }


def chains(certificate: Certificate) -> list[ProvenChain]:
    """List the chains of a certificate: of the machine as configured, and of the uncertain machines."""
    tolerances, following = [certificate.link_length, certificate.coordinates], certificate.following
    profiles: list[ProvenChain] = []
    if following is not None:
        tolerances += [*following.within_limits.values(), *following.on_branch.values(), following.calibrated]
        profiles = list(following.profiles.values())
    uncertain = [tolerance.chain for tolerance in tolerances if tolerance is not None]
    return [certificate.chain, *(chain for chain in uncertain if chain is not None), *profiles]


def read_certificate(file: pathlib.Path) -> Statement:
    """Read what can be verified of a certificate.

    Raises
    ------
    UsageError
        When the file does not exist, is damaged or of another format, or says that the path is not certified.
    """
    data = read_certificate_json(file)
    # 3.0 and true are no versions, although Python has them equal to whole numbers.
    if type(version := data.get("format")) is not int or version != FORMAT:
        written = "names no format" if version is None else f"is of format {json.dumps(version, default=str)[:40]}"
        raise UsageError(f"{file} {written}; this version reads format {FORMAT}.{ADVICE}")
    if (verdict := data.get("verdict")) == NOT_CERTIFIED:
        raise UsageError(f"{file} says that the path is {verdict}: there is nothing to verify.{ADVICE}")
    if (boxes := _count_boxes(data.get("chains"))) > MOST_BOXES:
        raise UsageError(f"{file} has {boxes:,} boxes; at most {MOST_BOXES:,} are verified.{ADVICE}")
    try:
        shape = certificate_shape(certificate_keys()).model_validate(data)
    except ValidationError as error:
        wrong = [explain(one) for one in error.errors(include_url=False)]
        more = [f"and {len(wrong) - _SHOWN} more"] if len(wrong) > _SHOWN else []
        lines = "\n  ".join(["", *wrong[:_SHOWN], *more])
        raise UsageError(f"{file} is not a certificate that can be verified:{lines}{ADVICE}") from None
    return Statement(
        path_sha256=shape.path_sha256,
        premises_sha256=shape.premises_sha256,
        boxes=shape.boxes,
        bounds=read_bounds(shape.bounds.model_dump(exclude_unset=True), certificate_keys()),
        link_length=_stated(shape.tolerances.link_length),
        coordinates=_stated(shape.tolerances.coordinates),
        chains=tuple(_chain(chain) for chain in shape.chains),
        following=StatedFollowing(
            within_limits={name: _read(one) for name, one in shape.tolerances.following_within_limits.items()},
            on_branch={name: _read(one) for name, one in shape.tolerances.following_on_branch.items()},
            calibrated=_calibrated(shape.tolerances.following_calibrated),
        ),
        machines=_machines(shape.tolerances.machines),
    )


def _count_boxes(chains: Any) -> int:
    """Count the boxes of all chains before any is looked at, whatever the file has in their place."""
    found = chains if isinstance(chains, list) else []
    radii = [chain.get("radius") for chain in found if isinstance(chain, dict)]
    return sum(len(boxes) for boxes in radii if isinstance(boxes, list))


def _stated(shape: ToleranceShape | None) -> StatedTolerance | None:
    return None if shape is None else _read(shape)


def _read(shape: ToleranceShape) -> StatedTolerance:
    reserve, limit, s = shape.tilt_reserve_deg, shape.stopped_by, shape.stopped_at_s
    stop = None if limit is None or s is None else (limit, s)
    return StatedTolerance(shape.proven_m, shape.boxes, None if reserve is None else (reserve[0], reserve[1]), stop)


def _calibrated(shape: CalibratedShape | None) -> StatedCalibrated | None:
    return None if shape is None else StatedCalibrated(_read(shape), shape.length_m, shape.coordinate_m)


def _chain(shape: ChainShape) -> ProvenChain:
    columns = zip(shape.s[:-1], shape.s[1:], shape.pose, shape.radius, strict=True)
    points = zip(shape.s, shape.joint_pose, shape.joint_radius, strict=True)
    return ProvenChain(
        uncertainty=_uncertainty(shape.uncertainty),
        boxes=tuple(Box(first, last, np.array(x), np.array(r)) for first, last, x, r in columns),
        joints=tuple(point_box(s, np.array(x), np.array(r)) for s, x, r in points),
        within_limits=shape.within_limits,
        profile_m=None if shape.profile_m is None else tuple(shape.profile_m),
    )


def _machines(shape: MachinesShape | None) -> StatedMachines | None:
    if shape is None:
        return None
    stated: dict[str, Any] = {
        key: tuple(value) if isinstance(value, list) else value for key, value in shape.model_dump().items()
    }
    return StatedMachines(**stated)


def _uncertainty(shape: UncertaintyShape) -> Uncertainty:
    found = Uncertainty(shape.length_m, shape.coordinate_m, tuple(shape.actuator_m))
    if (one := shape.ellipsoid) is None:
        return found
    return replace(
        found,
        ellipsoid=Ellipsoid(np.array(one.factor), one.sigma, np.array(one.zero_at_m), np.array(one.scale)),
    )


def _tolerance_dict(tolerance: Tolerance | None) -> dict[str, Any] | None:
    if tolerance is None:
        return None
    reserve, stop = tolerance.tilt_reserve_deg, tolerance.stopped_by
    return {
        "proven_m": tolerance.eps_m,
        "not_proven_m": tolerance.refuted_m,
        "monte_carlo_fails_m": tolerance.fails_m,
        "boxes": 0 if tolerance.chain is None else len(tolerance.chain.boxes),
        **({} if reserve is None else {"tilt_reserve_deg": list(reserve)}),
        **({} if stop is None else {"stopped_by": stop.reason.limit, "stopped_at_s": stop.s}),
    }


def _following_dict(following: FollowingTolerances) -> dict[str, Any]:
    """Arrange the tolerances of following errors; certificates without them have no keys for them."""
    found: dict[str, Any] = {
        "following_within_limits": {name: _tolerance_dict(one) for name, one in following.within_limits.items()},
        "following_on_branch": {name: _tolerance_dict(one) for name, one in following.on_branch.items()},
    }
    if (one := following.calibrated) is not None:
        errors = CERTAIN if one.chain is None else one.chain.uncertainty
        beside = {"length_m": errors.length_m, "coordinate_m": errors.coordinate_m}
        found["following_calibrated"] = {**(_tolerance_dict(one) or {}), **beside}
    return found


def _uncertainty_dict(uncertainty: Uncertainty) -> dict[str, Any]:
    """Arrange an uncertainty; errors of actuators, and machines of a calibration, only where there are any."""
    errors: dict[str, Any] = {"length_m": uncertainty.length_m, "coordinate_m": uncertainty.coordinate_m}
    if any(uncertainty.actuator_m):
        errors["actuator_m"] = list(uncertainty.actuator_m)
    if (one := uncertainty.ellipsoid) is not None:
        errors["ellipsoid"] = {field.name: getattr(one, field.name) for field in fields(one)}
    return errors


def _chain_dict(chain: ProvenChain) -> dict[str, Any]:
    return {
        "uncertainty": _uncertainty_dict(chain.uncertainty),
        **({"within_limits": True} if chain.within_limits else {}),
        **({} if chain.profile_m is None else {"profile_m": list(chain.profile_m)}),
        "s": [box.first for box in chain.boxes] + [box.last for box in chain.boxes[-1:]],
        "pose": [box.pose.tolist() for box in chain.boxes],
        "radius": [box.radius.tolist() for box in chain.boxes],
        "joint_pose": [joint.pose[0].tolist() for joint in chain.joints],
        "joint_radius": [joint.radius.tolist() for joint in chain.joints],
    }
