"""What a path has to keep besides being regular, and what every proven box says about it."""

from dataclasses import dataclass
from functools import partial

import numpy as np
from flint import arb

from pipeline.arrays import FloatArray
from pipeline.certify.chain import Examine
from pipeline.config import Config
from pipeline.inclusion.closure import Geometry
from pipeline.inclusion.condition import above, below, kappa_bound
from pipeline.inclusion.distances import Pairs, build_pairs, distance_bounds
from pipeline.inclusion.krawczyk import Inclusion, Piecewise
from pipeline.inclusion.pieces import Piece, middle
from pipeline.inclusion.ranges import polynomial_range
from pipeline.machine.geometry import ACTUATORS, LINKS, Machine
from pipeline.refine.path_limits import TILTS, kappa_cap, tilt_limits_deg

_SHARP_ENOUGH = 1e-5
"""Boxes are not halved below this width only to bound kappa more sharply."""
ROUNDING = 1e-6
"""Metres and radians by which a bound of actuators or tilt may pass a limit that the path was made to touch."""
MARGIN = 3e-4
"""What bounds of kappa are weakened by, relatively, so that other arithmetic can verify them."""
GAP_M = 5e-5
"""What bounds of distances are weakened by."""
SLIP = 1e-5
"""Metres and radians that bounds of actuators and tilts are weakened by."""


@dataclass(frozen=True, eq=False)
class Limits:
    """What is to be kept everywhere.

    Attributes
    ----------
    kappa_max : float
        The cap on kappa.
    kappa_goal : float
        How sharp the bound of kappa is wanted: boxes are halved until they are below it.
    sharp_width : float
        Boxes narrower than this are not halved for that.
    actuators_m : (5, 2)
        Travel and strokes.
    tilt_rad : (2,)
        Largest |rx| and |rz|.
    link_link_m, link_rail_m : float
        Least distances; NaN where rails are not looked at.
    """

    kappa_max: float
    kappa_goal: float
    sharp_width: float
    actuators_m: FloatArray
    tilt_rad: FloatArray
    link_link_m: float
    link_rail_m: float


@dataclass(frozen=True, eq=False)
class Facts:
    """Bounds over one box.

    Attributes
    ----------
    kappa, det_sign : float, int
        Upper bound of kappa; sign of det H.
    distances_m : (pairs,)
        Lower bounds of the distances of all pairs.
    actuators_m : (5, 2)
        Bounds below and above.
    tilt_rad : (2,)
        Upper bounds of |rx| and |rz|.
    """

    kappa: float
    det_sign: int
    distances_m: FloatArray
    actuators_m: FloatArray
    tilt_rad: FloatArray


def build_limits(config: Config, machine: Machine, kappa_sampled: float) -> Limits:
    """Read the limits off the configuration; the bound of kappa is wanted near its largest value at samples."""
    cap = kappa_cap(config)
    return Limits(
        kappa_max=cap,
        kappa_goal=min(cap, (1.0 + config.certify.kappa_excess) * kappa_sampled),
        # A box that would not be halved any more must not be refused for want of sharpness.
        sharp_width=max(_SHARP_ENOUGH, 2.0 * config.certify.least_width),
        actuators_m=machine.actuator_limits_m,
        tilt_rad=np.deg2rad(tilt_limits_deg(config)),
        link_link_m=machine.link_link_m,
        link_rail_m=machine.link_rail_m,
    )


def examiner(machine: Machine, balls: Geometry, limits: Limits) -> Examine[Facts]:
    """Make the function that bounds everything over a proven box and holds it against the limits."""
    return partial(_examine, balls, build_pairs(machine), limits)


def _examine(
    balls: Geometry, pairs: Pairs, limits: Limits, piece: Piece, series: Piecewise, inclusion: Inclusion
) -> tuple[Facts, str]:
    kappa = kappa_bound(balls, series, inclusion.image)
    facts = Facts(
        kappa=kappa.kappa * (1.0 + MARGIN),
        det_sign=kappa.det_sign,
        distances_m=np.maximum(distance_bounds(balls, pairs, series, inclusion.image) - GAP_M, 0.0),
        actuators_m=_actuators(piece, inclusion, series.half) + [-SLIP, SLIP],
        tilt_rad=_tilts(inclusion, series.half) + SLIP,
    )
    width = inclusion.box.last - inclusion.box.first
    if facts.kappa > limits.kappa_goal and width >= limits.sharp_width:
        return facts, f"kappa is not proven below {limits.kappa_goal:.4g}"
    return facts, _breach(pairs, limits, facts)


def _breach(pairs: Pairs, limits: Limits, facts: Facts) -> str:
    """Name the first limit that is not proven to be kept; nothing where all are."""
    if not facts.kappa <= limits.kappa_max:
        return f"kappa is not proven below its cap {limits.kappa_max:g} (bound {facts.kappa:.4g})"
    least = np.array([limits.link_link_m] * len(pairs.links) + [limits.link_rail_m] * len(pairs.rails))
    if len(least) and (short := facts.distances_m - least).min() < 0.0:
        worst = int(short.argmin())
        return f"{pair_name(pairs, worst)} are not proven {least[worst]:g} m apart ({facts.distances_m[worst]:.4g} m)"
    excess = np.maximum(
        limits.actuators_m[:, 0] - facts.actuators_m[:, 0], facts.actuators_m[:, 1] - limits.actuators_m[:, 1]
    )
    if excess.max() > ROUNDING + SLIP:
        worst = int(excess.argmax())
        return f"{ACTUATORS[worst]} is not proven to stay within its limits (beyond by {excess[worst]:.3g} m)"
    over = facts.tilt_rad - limits.tilt_rad
    if over.max() > ROUNDING + SLIP:
        name = TILTS[int(over.argmax())][0]
        return f"{name} is not proven to stay within its limit (beyond by {np.rad2deg(over.max()):.3g} degrees)"
    return ""


def pair_name(pairs: Pairs, pair: int) -> str:
    """Tell which pair it is."""
    if pair < len(pairs.links):
        a, b = pairs.links[pair]
        return f"links {LINKS[a]} and {LINKS[b]}"
    link, rail = pairs.rails[pair - len(pairs.links)]
    return f"link {LINKS[link]} and rail {rail + 1}"


def _actuators(piece: Piece, inclusion: Inclusion, half: arb) -> FloatArray:
    centre, _ = middle(inclusion.box.first, inclusion.box.last)
    ranges = [polynomial_range([arb(value) for value in q], half) for q in piece.taylor(centre)]
    return np.array([(below(least), above(largest)) for least, largest in ranges])


def _tilts(inclusion: Inclusion, half: arb) -> FloatArray:
    bounds = []
    for _, index in TILTS:
        least, largest = polynomial_range([arb(value) for value in inclusion.box.pose[:, index].tolist()], half)
        bounds.append(above(largest.max(-least) + inclusion.image[index]))
    return np.array(bounds)
