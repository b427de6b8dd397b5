"""One statement of a certificate, and whether it was verified."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Claim:
    """A claim of a certificate.

    Attributes
    ----------
    what : str
        What it states.
    verified : bool
        Whether it was verified.
    found : str
        What was found.
    """

    what: str
    verified: bool
    found: str
