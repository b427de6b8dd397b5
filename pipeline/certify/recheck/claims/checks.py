"""The table of what is verified of the bounds that a certificate states: one module per limit, and both ends."""

from collections.abc import Iterator
from typing import Protocol

from pipeline.certify.bounds import Bounds
from pipeline.certify.recheck.claims import actuators, axis_distances, endpoints, holding_force, kappa, tilt
from pipeline.certify.recheck.claims.claim import Claim
from pipeline.certify.recheck.claims.evidence import Evidence


class BoundCheck(Protocol):
    """What the module of a check offers. It has arithmetic of its own and uses no bound of `pipeline.limits`."""

    CLAIMS: tuple[str, ...]
    """What it verifies, in words."""
    KEYS: tuple[str, ...]
    """The keys of certificate.json whose bounds it verifies."""

    def check(self, evidence: Evidence, stated: Bounds) -> Iterator[Claim]:
        """Verify what is stated against the boxes, and against the limits of the configuration."""


CHECKS: tuple[BoundCheck, ...] = (kappa, axis_distances, holding_force, actuators, tilt, endpoints)
"""All checks, in the order in which their claims are shown."""


def bound_claims(evidence: Evidence, stated: Bounds) -> Iterator[Claim]:
    """Verify all bounds that a certificate states; a bound without a check is not verified."""
    for module in CHECKS:
        yield from module.check(evidence, stated)
    checked = {key for module in CHECKS for key in module.KEYS}
    for key in stated.ranges:
        if key not in checked:
            yield Claim(f"bounds.{key} can be verified", verified=False, found="there is no check of it")
