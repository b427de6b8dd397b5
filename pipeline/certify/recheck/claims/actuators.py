"""Cart travel and telescope strokes."""

from collections.abc import Iterator

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.bounds import Bounds
from pipeline.certify.recheck.arithmetic.chain import EvaluatedChain
from pipeline.certify.recheck.arithmetic.ranges import polynomial_ranges
from pipeline.certify.recheck.claims.claim import Claim
from pipeline.certify.recheck.claims.evidence import Evidence
from pipeline.config import Config
from pipeline.limits.actuator_margins import planned_range_m
from pipeline.limits.actuators import PROOF_ROUNDING_M, PROOF_SLACK_M
from pipeline.machine.geometry import ACTUATORS, Machine

RANGES = "carts and telescopes stay within bounds and limits"
CLAIMS: tuple[str, ...] = (RANGES,)
KEYS: tuple[str, ...] = ("actuators_m",)

_BEYOND_M = PROOF_ROUNDING_M + PROOF_SLACK_M
"""How far a stated bound may be beyond a limit."""


def measure(config: Config, machine: Machine, segment: EvaluatedChain) -> FloatArray:
    """Bound the positions of all actuators over some boxes."""
    least, largest = polynomial_ranges(segment.boxes.q, segment.boxes.half)
    return np.column_stack([least.min(axis=1), largest.max(axis=1)])


def check(evidence: Evidence, stated: Bounds) -> Iterator[Claim]:
    """Verify the ranges of all actuators for every s."""
    ranges, limits = evidence.found, planned_range_m(evidence.config, evidence.machine)
    rows = zip(ACTUATORS, ranges, stated.actuators_m, limits, strict=True)
    yield Claim(
        RANGES,
        _inside(ranges, stated.actuators_m) and _inside(stated.actuators_m, limits + [-_BEYOND_M, _BEYOND_M]),
        "\n".join(
            f"{name} {_span(one)}, stated {_span(bound)}, limits {limit[0]:g} to {limit[1]:g} m"
            for name, one, bound, limit in rows
        ),
    )


def _inside(ranges: FloatArray, of: FloatArray) -> bool:
    """Return whether ranges (n, 2) lie within others."""
    return bool((ranges[:, 0] >= of[:, 0]).all() and (ranges[:, 1] <= of[:, 1]).all())


def _span(values: FloatArray) -> str:
    return f"{values[0]:.5g} to {values[1]:.5g}"
