"""What is verified of a certificate, one statement at a time."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Claim:
    """A claim of a certificate: what it says, whether it was verified, and what was found."""

    what: str
    verified: bool
    found: str
