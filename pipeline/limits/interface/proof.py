"""What a certificate states of a kind of limit: the keys of its file, and the configured values it rests on."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, auto
from typing import Any

from pipeline.config import Config


class Side(Enum):
    """Which bounds of a quantity are stated, in the order in which tables show them.

    `SIGN` is the sign that a quantity has everywhere, -1 or 1. `LARGEST` and `LEAST` are bounds of magnitudes, which
    are not negative; `FLOOR` is the least value of what has either sign.
    """

    BOTH = auto()
    LARGEST = auto()
    LEAST = auto()
    FLOOR = auto()
    SIGN = auto()


@dataclass(frozen=True)
class CertificateKey:
    """A key within `bounds` of certificate.json.

    Attributes
    ----------
    name : str
        The key. Values are stated in the unit of the bounds, which is the one that the key ends in.
    side : Side
        Which bounds are stated.
    subjects : tuple of str or None
        The names that its section holds; empty if there is a single value; None if they depend on the machine.
    label, unit : str
        How tables name a quantity ("|{}|", filled with the subject), and its unit.
    decimals : int
        Decimals of its bounds in tables.
    optional : bool
        Whether a certificate may leave the key out, since its limit is not always configured.
    """

    name: str
    side: Side
    subjects: tuple[str, ...] | None = ()
    label: str = "{}"
    unit: str = ""
    decimals: int = 3
    optional: bool = False


@dataclass(frozen=True)
class ProvenQuantity:
    """A quantity that a certificate bounds.

    Attributes
    ----------
    key : CertificateKey
        Where its bounds are stated.
    subject : str
        Its name within the section of the key: "links 1 and 2a".
    allowed : (float, float)
        Its limits; infinite on a side without one.
    """

    key: CertificateKey
    subject: str
    allowed: tuple[float, float]


@dataclass(frozen=True)
class CertificateEntry:
    """What certificates state of a kind of limit.

    Attributes
    ----------
    keys : tuple of CertificateKey
        The keys of its bounds; none if it is not proven.
    premises : callable
        Returns the configured values that its limit follows from, apart from the machine's geometry and clearance,
        by keys of their own.
    """

    keys: tuple[CertificateKey, ...] = ()
    premises: Callable[[Config], dict[str, Any]] = lambda config: {}
