"""A certificate verified again: the same statements, other code, other arithmetic, all boxes at once."""

from pipeline.certify.recheck.verdict import Claim, verify

__all__ = ["Claim", "verify"]
