"""What a chain of all machines of a calibration claims beside one pose and limits: how far these are off the path."""

from collections.abc import Iterator

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.bounds import Bounds
from pipeline.certify.recheck.arithmetic.chain import EvaluatedChain
from pipeline.certify.recheck.arithmetic.enclosure import times, total
from pipeline.certify.recheck.claims.claim import Claim
from pipeline.certify.recheck.statement import StatedMachines, Statement
from pipeline.config import Config
from pipeline.limits.tilt import path_limits_deg
from pipeline.machine.geometry import ACTUATORS, Machine
from pipeline.machine.pose import TILT_COLUMNS

RANGES = "tilts, travel and strokes of all machines are within their limits where that is stated"
RESERVE = "rx, rz, carts and telescopes are off the path by no more than stated"


def off_path(machine: Machine, segment: EvaluatedChain) -> FloatArray:
    """Bound how far rx and rz, in degrees, and the five actuators, in metres, are off over some boxes. Shape (7,)."""
    off = segment.displacement(machine)
    # The float nearest to pi is below it: this factor is above the exact one.
    tilts = times(off.pose[TILT_COLUMNS].max(axis=1), total(np.array(180.0 / np.pi)))
    return np.concatenate([tilts, off.actuators.max(axis=1)])


def range_claims(config: Config, machine: Machine, stated: Statement) -> Iterator[Claim]:
    """Verify that ranges are kept with what is in reserve, if that is stated: from bounds that are verified, too."""
    if (said := stated.machines) is not None:
        beyond = beyond_range(config, machine, stated.bounds, (said.tilt_reserve_deg, said.actuator_reserve_m))
        kept = said.ranges_kept is False or not beyond
        yield Claim(
            RANGES, kept, f"beyond: {', '.join(beyond) or 'none'}; stated {'kept' if said.ranges_kept else 'no'}"
        )


def beyond_range(
    config: Config, machine: Machine, bounds: Bounds, reserves: tuple[tuple[float, ...], tuple[float, ...]]
) -> list[str]:
    """Name tilts and actuators that are not within limits with what machines are off by, in degrees and metres."""
    tilt_deg, actuators_m = (np.array(values) for values in reserves)
    limits, room = machine.actuator_limits_m, np.array(path_limits_deg(config)) - bounds.tilt_deg - tilt_deg
    low, high = bounds.actuators_m[:, 0] - actuators_m, bounds.actuators_m[:, 1] + actuators_m
    within = (low >= limits[:, 0]) & (high <= limits[:, 1])
    tilts = [name for name, left in zip(("rx", "rz"), room.tolist(), strict=True) if not left >= 0.0]
    return tilts + [name for name, kept in zip(ACTUATORS, within.tolist(), strict=True) if not kept]


def reserve_claim(of: str, found: FloatArray, stated: StatedMachines | None) -> Claim:
    """Verify what limits need in reserve that the path may touch: of tilts, of travel and strokes."""
    most = np.full(7, -np.inf) if stated is None else np.array([*stated.tilt_reserve_deg, *stated.actuator_reserve_m])
    kept = bool((found <= most).all())
    text = f"tilts {found[:2].max():.4g} degrees, actuators {1e3 * found[2:].max():.4g} mm"
    return Claim(f"{of}: {RESERVE}", kept, text if kept else f"{text}; stated less")
