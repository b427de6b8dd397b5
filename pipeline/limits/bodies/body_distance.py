"""The least distance between the surfaces of bodies that move (`machine.bodies`, `machine.link_bodies`)."""

from collections.abc import Sequence
from typing import Any

from pipeline.config import Config
from pipeline.limits.axis_distance import distance_relaxation
from pipeline.limits.bodies.obstruction import obstruction
from pipeline.limits.bodies.pairs import kept_apart
from pipeline.limits.bodies.surface_distance import SurfaceDistance
from pipeline.limits.interface.limit import Limit
from pipeline.limits.interface.measure import Measure
from pipeline.limits.interface.proof import CertificateEntry, CertificateKey, Side
from pipeline.limits.interface.relaxation import Relaxation, with_values
from pipeline.machine.bodies.distances import body_distances, least_distance
from pipeline.machine.geometry import Machine
from pipeline.machine.samples import PoseSamples

BODY_DISTANCE = CertificateKey("body_distance_m", Side.LEAST, None, "least distance of bodies", "m", 5, optional=True)


def for_poses(machine: Machine, kappa_max: float) -> list[Limit]:
    """Return the limit of poses by themselves: none if there are no bodies."""
    if machine.bodies is None:
        return []
    return [SurfaceDistance(machine.bodies, BODY_DISTANCE, "body distance", "bodies")]


def for_moves(config: Config, machine: Machine) -> list[Limit]:
    """Return the limit of moves between regions."""
    return for_poses(machine, config.route.kappa_max)


def for_path(config: Config, machine: Machine) -> list[Limit]:
    """Return the limit of a path."""
    return for_poses(machine, config.route.kappa_max)


def relaxations(config: Config, machine: Machine) -> list[Relaxation]:
    """Return smaller distances down to zero, then the machine without its bodies, and without each of them."""
    pairs, bodies = machine.bodies, config.machine.bodies
    found = []
    if pairs is not None:
        found += distance_relaxation(
            config, "bodies_m", lambda samples: body_distances(pairs, samples, pairs.clearance_m)
        )
    whole = "machine.bodies" if len(bodies) > 1 else ""
    if whole:
        found.append(_removal(config, machine, bodies, whole))
    for k, body in enumerate(bodies):
        found.append(_removal(config, machine, (body,), f"machine.bodies[{k}]", whole))
    return found


def _removal(config: Config, machine: Machine, bodies: Sequence[Any], key: str, part_of: str = "") -> Relaxation:
    """Remove bodies, and say how they would be in the way."""
    names = {body.name for body in bodies}

    def words(samples: PoseSamples) -> str:
        found = (obstruction(pairs, names, samples) for pairs in kept_apart(config, machine))
        return "; ".join(filter(None, found))

    return Relaxation.removal(key, without(config, bodies), part_of, words)


def without(config: Config, bodies: Sequence[Any]) -> Config:
    """Return the configuration without some bodies, and without ignored pairs of them."""
    names = {body.name for body in bodies}
    clearance = config.machine.clearance
    kept = tuple(pair for pair in clearance.ignore if names.isdisjoint(pair))
    return with_values(
        config,
        "machine",
        bodies=tuple(body for body in config.machine.bodies if body.name not in names),
        clearance=clearance.model_copy(update={"ignore": kept}),
    )


def _premises(config: Config) -> dict[str, Any]:
    """Give what bodies there are: nothing without any, so that certificates of such machines stay."""
    found = config.machine.model_dump(mode="json", include={"bodies", "link_bodies"})
    return {"bodies": found} if found else {}


def _least(samples: PoseSamples) -> float:
    assert samples.machine.bodies is not None
    return least_distance(samples.machine.bodies, samples)


CERTIFICATE = CertificateEntry((BODY_DISTANCE,), _premises)
MEASURES: tuple[Measure, ...] = (
    Measure(
        key="min_body_distance_m",
        name="least body distance",
        unit="m",
        prefers="higher",
        resolution=1e-5,
        reduce=_least,
        applies=lambda machine: machine.bodies is not None,
    ),
)
