"""The table of what is verified of the bounds that a certificate states: one module per limit."""

from collections.abc import Iterator, Sequence
from typing import Protocol

from pipeline.arrays import FloatArray
from pipeline.certify.bounds import Bounds
from pipeline.certify.recheck.arithmetic.chain import EvaluatedChain
from pipeline.certify.recheck.claims import actuators, kappa
from pipeline.certify.recheck.claims.claim import Claim
from pipeline.certify.recheck.claims.controlled import avoided, tilt
from pipeline.certify.recheck.claims.distances import axis_distances, body_distances
from pipeline.certify.recheck.claims.evidence import Evidence, combined
from pipeline.certify.recheck.claims.gravity import holding_force, stiffness
from pipeline.certify.recheck.claims.joints import angles
from pipeline.config import Config
from pipeline.machine.geometry import Machine


class BoundCheck(Protocol):
    """What the module of a check offers. It has arithmetic of its own and uses no bound of `pipeline.limits`."""

    CLAIMS: tuple[str, ...]
    """What it verifies, in words."""
    KEYS: tuple[str, ...]
    """The keys of certificate.json whose bounds it verifies."""

    def measure(self, config: Config, machine: Machine, segment: EvaluatedChain) -> FloatArray:
        """Bound the limited quantities over some boxes from below and above, shape (m, 2)."""

    def check(self, evidence: Evidence, stated: Bounds) -> Iterator[Claim]:
        """Verify what is stated against the bounds over all boxes, and against the limits of the configuration."""


CHECKS: tuple[BoundCheck, ...] = (
    kappa,
    axis_distances,
    body_distances,
    holding_force,
    stiffness,
    actuators,
    tilt,
    angles,
    avoided,
)
"""All checks, in the order in which their claims are shown."""


def measure_all(
    config: Config, machine: Machine, segment: EvaluatedChain, before: Sequence[FloatArray] | None
) -> list[FloatArray]:
    """Bound everything over a segment of boxes as well as over those `before` it, an array per check."""
    found = [module.measure(config, machine, segment) for module in CHECKS]
    return found if before is None else [combined(one, more) for one, more in zip(before, found, strict=True)]


def bound_claims(config: Config, machine: Machine, found: Sequence[FloatArray], stated: Bounds) -> Iterator[Claim]:
    """Verify all bounds that a certificate states; a bound without a check is not verified."""
    for module, bounds in zip(CHECKS, found, strict=True):
        yield from module.check(Evidence(config, machine, bounds), stated)
    checked = {key for module in CHECKS for key in module.KEYS}
    for key in stated.ranges:
        if key not in checked:
            yield Claim(f"bounds.{key} can be verified", verified=False, found="there is no check of it")
