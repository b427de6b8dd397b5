"""The tilts about x and z."""

from collections.abc import Iterator

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.bounds import Bounds
from pipeline.certify.recheck.arithmetic.enclosure import exactly, total
from pipeline.certify.recheck.arithmetic.inclusion import Boxes
from pipeline.certify.recheck.arithmetic.ranges import polynomial_ranges
from pipeline.certify.recheck.claims.claim import Claim
from pipeline.certify.recheck.claims.evidence import Evidence
from pipeline.limits.tilt import PROOF_ROUNDING_RAD, PROOF_SLACK_RAD, path_limits_deg
from pipeline.machine.pose import TILT_AXES, TILT_COLUMNS

TILTS = "tilts stay within bounds and limits"
CLAIMS: tuple[str, ...] = (TILTS,)
KEYS: tuple[str, ...] = ("tilt_deg",)

_BEYOND_RAD = PROOF_ROUNDING_RAD + PROOF_SLACK_RAD
"""How far a stated bound may be beyond a limit."""


def check(evidence: Evidence, stated: Bounds) -> Iterator[Claim]:
    """Verify the bounds of |rx| and |rz| for every s."""
    tilt = tilt_bounds(evidence.chain.boxes, evidence.chain.inclusions.image)
    bound, limit = np.deg2rad(stated.tilt_deg), np.deg2rad(path_limits_deg(evidence.config))
    degrees = (np.rad2deg(values) for values in (tilt, bound, limit))
    yield Claim(
        TILTS,
        bool((tilt <= bound).all() and (bound <= limit + _BEYOND_RAD).all()),
        "\n".join(
            f"{name} {one:.5g}, stated {most:.5g}, limit {allowed:.5g} degrees"
            for name, one, most, allowed in zip(TILT_AXES, *degrees, strict=True)
        ),
    )


def tilt_bounds(boxes: Boxes, deviation: FloatArray) -> FloatArray:
    """Bound |rx| and |rz| over all boxes from above, for poses within `deviation` (6, n) of the cubics. Shape (2,)."""
    least, largest = polynomial_ranges(exactly(boxes.pose[:, TILT_COLUMNS]), boxes.half)
    return np.asarray(total(np.maximum(-least, largest), deviation[TILT_COLUMNS]).max(axis=1), dtype=float)
