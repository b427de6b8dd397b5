"""A certificate verified again: the same statements, other code, other arithmetic, all boxes at once."""

from pipeline.certify.recheck.claim import Claim
from pipeline.certify.recheck.profile import KappaProfile, kappa_profile
from pipeline.certify.recheck.statement import StatedTolerance, Statement
from pipeline.certify.recheck.verdict import MANDATORY, verify

__all__ = ["MANDATORY", "Claim", "KappaProfile", "StatedTolerance", "Statement", "kappa_profile", "verify"]
