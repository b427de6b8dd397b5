"""The tilts about x and z."""

from collections.abc import Iterator

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.bounds import Bounds
from pipeline.certify.recheck.arithmetic.chain import EvaluatedChain
from pipeline.certify.recheck.arithmetic.enclosure import exactly, times, total
from pipeline.certify.recheck.arithmetic.inclusion import Boxes
from pipeline.certify.recheck.arithmetic.ranges import polynomial_ranges
from pipeline.certify.recheck.claims.claim import Claim
from pipeline.certify.recheck.claims.evidence import Evidence, upper_bounds
from pipeline.config import Config
from pipeline.limits.tilt import PROOF_ROUNDING_RAD, PROOF_SLACK_RAD, path_limits_deg
from pipeline.machine.geometry import Machine
from pipeline.machine.pose import TILT_AXES, TILT_COLUMNS

TILTS = "tilts stay within bounds and limits"
CLAIMS: tuple[str, ...] = (TILTS,)
KEYS: tuple[str, ...] = ("tilt_deg",)

_BEYOND_DEG = float(np.rad2deg(PROOF_ROUNDING_RAD + PROOF_SLACK_RAD))
"""How far a stated bound may be beyond a limit."""


def measure(config: Config, machine: Machine, segment: EvaluatedChain) -> FloatArray:
    """Bound |rx| and |rz| over some boxes, in degrees."""
    tilt = tilt_bounds(segment.boxes, segment.inclusions.image)
    # The float nearest to pi is below it: this factor is above the exact one.
    return upper_bounds(times(tilt, total(np.array(180.0 / np.pi))))


def check(evidence: Evidence, stated: Bounds) -> Iterator[Claim]:
    """Verify the bounds of |rx| and |rz| for every s."""
    tilt, bound, limit = evidence.largest, stated.tilt_deg, np.array(path_limits_deg(evidence.config))
    degrees = (tilt, bound, limit)
    yield Claim(
        TILTS,
        bool((tilt <= bound).all() and (bound <= limit + _BEYOND_DEG).all()),
        "\n".join(
            f"{name} {one:.5g}, stated {most:.5g}, limit {allowed:.5g} degrees"
            for name, one, most, allowed in zip(TILT_AXES, *degrees, strict=True)
        ),
    )


def tilt_bounds(boxes: Boxes, deviation: FloatArray) -> FloatArray:
    """Bound |rx| and |rz| over all boxes from above, for poses within `deviation` (6, n) of the cubics. Shape (2,)."""
    least, largest = polynomial_ranges(exactly(boxes.pose[:, TILT_COLUMNS]), boxes.half)
    return np.asarray(total(np.maximum(-least, largest), deviation[TILT_COLUMNS]).max(axis=1), dtype=float)
