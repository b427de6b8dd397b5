"""The certificate as a file: what people read of it first, then the boxes with which it can be verified again."""

import json
import pathlib
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from pipeline.artifacts.files import plain
from pipeline.artifacts.pack import readable
from pipeline.certify.guess import point_box
from pipeline.certify.inclusion import Box
from pipeline.certify.result import CERTIFIED, Bounds, Certificate, ProvenChain, Tolerance
from pipeline.certify.uncertainty import Uncertainty
from pipeline.errors import UsageError
from pipeline.machine.geometry import ACTUATORS

FORMAT = 1
"""Of the file; raised when its meaning changes."""


def certificate_bytes(certificate: Certificate, facts: Mapping[str, Any]) -> bytes:
    """Write a certificate: the facts a line each, every chain on one line."""
    value = plain(certificate_dict(certificate, facts))
    proofs = ",\n    ".join(json.dumps(chain, allow_nan=False) for chain in value.pop("chains"))
    head = json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False).removesuffix("\n}")
    return f'{head},\n  "chains": [\n    {proofs}\n  ]\n}}\n'.encode()


def certificate_dict(certificate: Certificate, facts: Mapping[str, Any]) -> dict[str, Any]:
    """Arrange a certificate for its file; `facts` are settings, versions and seconds that it knows nothing of."""
    broken, link_length, coordinates = certificate.broken, certificate.link_length, certificate.coordinates
    return {
        "format": FORMAT,
        "verdict": certificate.verdict,
        "refused_at_s": None if broken is None else broken.s,
        "refused_because": None if broken is None else broken.why,
        "boxes": len(certificate.chain.boxes),
        "path_sha256": certificate.path_sha256,
        "bounds": None if certificate.bounds is None else bounds_dict(certificate.bounds),
        "tolerance_m": None if link_length is None else link_length.eps_m,
        "coordinates_tolerance_m": None if coordinates is None else coordinates.eps_m,
        "tolerances": {
            "link_length": _tolerance_dict(link_length),
            "coordinates": _tolerance_dict(coordinates),
        },
        "precision_bits": certificate.precision_bits,
        **facts,
        "chains": [_chain_dict(chain) for chain in chains(certificate)],
    }


def chains(certificate: Certificate) -> list[ProvenChain]:
    """All chains a certificate stands on: of the machine as configured, and of the uncertain ones."""
    tolerances = (certificate.link_length, certificate.coordinates)
    uncertain = [tolerance.chain for tolerance in tolerances if tolerance is not None]
    return [certificate.chain, *(chain for chain in uncertain if chain is not None)]


def bounds_dict(bounds: Bounds) -> dict[str, Any]:
    """Arrange the bounds, each named with its unit."""
    return {
        "kappa": bounds.kappa,
        "kappa_s": bounds.kappa_s,
        "det_sign": bounds.det_sign,
        "distance_m": dict(zip(bounds.pairs, bounds.distances_m.tolist(), strict=True)),
        "actuators_m": dict(zip(ACTUATORS, bounds.actuators_m.tolist(), strict=True)),
        "tilt_deg": dict(zip(("rx", "rz"), np.rad2deg(bounds.tilt_rad).tolist(), strict=True)),
        "start_miss": bounds.start_miss,
        "goal_miss": bounds.goal_miss,
    }


@dataclass(frozen=True, eq=False)
class StoredCertificate:
    """What a certificate's file claims: the hash of its path, bounds, and the chains of boxes."""

    path_sha256: str
    bounds: Bounds
    chains: list[ProvenChain]


def read_certificate(file: pathlib.Path) -> StoredCertificate:
    """Read what can be verified of a certificate.

    Raises
    ------
    UsageError
        When the file does not exist, or is no certificate of a certified path.
    """
    try:
        data = json.loads(file.read_bytes())
    except FileNotFoundError:
        raise UsageError(f"{file} does not exist.\n  What to change: name a certificate.json of a run.") from None
    except ValueError as error:
        raise UsageError(f"{file} is no certificate ({error})") from None
    with readable(file):
        if data["verdict"] != CERTIFIED:
            raise UsageError(f"{file} says that the path is {data['verdict']}: there is nothing to verify")
        return StoredCertificate(data["path_sha256"], _read_bounds(data["bounds"]), _read_chains(data["chains"]))


def _read_bounds(data: Mapping[str, Any]) -> Bounds:
    return Bounds(
        kappa=data["kappa"],
        kappa_s=data["kappa_s"],
        det_sign=data["det_sign"],
        pairs=tuple(data["distance_m"]),
        distances_m=np.array(list(data["distance_m"].values())),
        actuators_m=np.array(list(data["actuators_m"].values())),
        tilt_rad=np.deg2rad(list(data["tilt_deg"].values())),
        start_miss=data["start_miss"],
        goal_miss=data["goal_miss"],
    )


def _read_chains(data: list[Mapping[str, Any]]) -> list[ProvenChain]:
    return [
        ProvenChain(
            uncertainty=Uncertainty(**chain["uncertainty"]),
            boxes=_read_boxes(chain["s"][:-1], chain["s"][1:], chain["pose"], chain["radius"]),
            joints=tuple(
                point_box(s, np.array(pose), np.array(radius))
                for s, pose, radius in zip(chain["s"], chain["joint_pose"], chain["joint_radius"], strict=True)
            ),
        )
        for chain in data
    ]


def _read_boxes(first: list[float], last: list[float], pose: list[Any], radius: list[Any]) -> tuple[Box, ...]:
    columns = zip(first, last, pose, radius, strict=True)
    return tuple(Box(a, b, np.array(x), np.array(r)) for a, b, x, r in columns)


def _tolerance_dict(tolerance: Tolerance | None) -> dict[str, Any] | None:
    if tolerance is None:
        return None
    return {
        "proven_m": tolerance.eps_m,
        "not_proven_m": tolerance.refuted_m,
        "monte_carlo_fails_m": tolerance.fails_m,
        "boxes": 0 if tolerance.chain is None else len(tolerance.chain.boxes),
    }


def _chain_dict(chain: ProvenChain) -> dict[str, Any]:
    return {
        "uncertainty": asdict(chain.uncertainty),
        "s": [box.first for box in chain.boxes] + [box.last for box in chain.boxes[-1:]],
        "pose": [box.pose.tolist() for box in chain.boxes],
        "radius": [box.radius.tolist() for box in chain.boxes],
        "joint_pose": [joint.pose[0].tolist() for joint in chain.joints],
        "joint_radius": [joint.radius.tolist() for joint in chain.joints],
    }
