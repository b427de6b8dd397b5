"""The independent check of a certificate: the same statements, other code, other arithmetic, all boxes at a time.

One module of `claims` verifies one claim. Of the search for a proof it shares only what need not be right: where boxes
are, and directions between axes.
"""

from pipeline.certify.recheck.claims.claim import Claim
from pipeline.certify.recheck.profile import KappaProfile, kappa_profile
from pipeline.certify.recheck.statement import (
    StatedCalibrated,
    StatedFollowing,
    StatedMachines,
    StatedTolerance,
    Statement,
)
from pipeline.certify.recheck.verdict import MANDATORY, verifies, verify

__all__ = [
    "MANDATORY",
    "Claim",
    "KappaProfile",
    "StatedCalibrated",
    "StatedFollowing",
    "StatedMachines",
    "StatedTolerance",
    "Statement",
    "kappa_profile",
    "verifies",
    "verify",
]
