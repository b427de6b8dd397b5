"""The words that keys of the configuration choose from, and what each means."""

from enum import StrEnum


class TriangleBranch(StrEnum):
    """Sign of y_platform . (w x u_3c) that the assembled machine keeps."""

    NEGATIVE = "negative"
    POSITIVE = "positive"


class TiltAxis(StrEnum):
    """A tilt of the platform that can be locked."""

    RX = "rx"
    RZ = "rz"


class RouteObjective(StrEnum):
    """What the route minimises: kappa added up over its length or its steps, its largest kappa, or time."""

    INTEGRAL = "integral"
    SUM = "sum"
    BOTTLENECK = "bottleneck"
    TIME = "time"


class Formulation(StrEnum):
    """The program that finds the route: over a proven core of the regions, or over all of them."""

    CORE = "core"
    COMPACT = "compact"
    PAPER = "paper"


class PathObjective(StrEnum):
    """What the path minimises: the integral of kappa, the largest kappa, or both; or the duration of the motion."""

    INTEGRAL = "integral"
    MAXIMUM = "maximum"
    MIXED = "mixed"
    TIME = "time"


class Corridor(StrEnum):
    """What the path keeps to: cells and working modes of the route, or its sequence of working modes only."""

    CELLS = "cells"
    FREE = "free"


class Proof(StrEnum):
    """What is proven of a path; each proves what those before it prove."""

    NOTHING = "nothing"
    PATH = "path"
    TOLERANCES = "tolerances"
    FOLLOWING = "following"


class BodyFrame(StrEnum):
    """What a body is attached to."""

    PLATFORM = "platform"
    CART1 = "cart1"
    CART2 = "cart2"
    CART3 = "cart3"
    RAIL1 = "rail1"
    RAIL2 = "rail2"
    RAIL3 = "rail3"
    FRAME = "frame"
    L1_CART = "l1_cart"
    L1_PLATFORM = "l1_platform"
    L2A_CART = "l2a_cart"
    L2A_PLATFORM = "l2a_platform"
    L2B_CART = "l2b_cart"
    L2B_PLATFORM = "l2b_platform"
    L3A_CART = "l3a_cart"
    L3A_PLATFORM = "l3a_platform"
    L3B_CART = "l3b_cart"
    L3B_PLATFORM = "l3b_platform"
    L3C_CART = "l3c_cart"
    L3C_PLATFORM = "l3c_platform"

    @property
    def link_end(self) -> tuple[str, float] | None:
        """The link ("l2b") and which end of it, 0 at the cart and 1 at the platform; None for all others."""
        link, _, end = self.value.partition("_")
        return (link, float(end == "platform")) if end else None
