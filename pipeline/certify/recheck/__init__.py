"""A certificate verified again: the same statements, other code, other arithmetic, all boxes at once."""

from pipeline.certify.recheck.profile import KappaProfile, kappa_profile
from pipeline.certify.recheck.verdict import Claim, verify

__all__ = ["Claim", "KappaProfile", "kappa_profile", "verify"]
