"""The stiffness that gravity gives the drives, as series over many boxes; K is that of `machine.actuator_space`."""

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.recheck.arithmetic.enclosure import Enclosure, bound, contract, cross, exactly, total
from pipeline.certify.recheck.arithmetic.motion import Motion, along_rails
from pipeline.machine.geometry import ACTUATORS, ARM_OF_LINK, LINKS, TELESCOPES, Machine
from pipeline.machine.masses import Masses, lumped_platform

ORDERS = 3
"""Orders of the series of K; the last one is to hold for whole intervals."""
_EVERY, _EXTENDING = np.arange(len(LINKS)), [3, 4]

Series = list[Enclosure]
"""Coefficients of orders 0 to 2, boxes last."""


def stiffness_series(machine: Machine, masses: Masses, motion: Motion) -> Series:
    """Compute K, each order (5, 5, n), for poses that need not close; every number where H may be singular."""
    body, n = lumped_platform(masses, machine.platform_points_m), motion.pose.mid.shape[-1]
    H, arms = _orders(motion.statics()), _orders(motion.arms)
    per_length = exactly(motion.characteristic_length).inverse()
    twist = _solved(H, _by_actuator(H, motion.rails))
    spin = [part[3:] * per_length for part in twist]
    weight = _constant(-body.mass_kg * masses.gravity_mps2, n)
    centre = [contract("ijn,j->in", part, exactly(body.centre_m), 3) for part in _orders(motion.rotation)]
    moment = _crossed(centre, weight, axis=0)
    wrench = [_joined(F, M * per_length)[:, None] for F, M in zip(weight, moment, strict=True)]
    link_n = [part[:, 0] for part in _solved([_transposed(part) for part in H], wrench)]
    pushed = _products("ln,lin->lin", link_n, [part[:, :3] for part in H], 1)
    turning = _turning(
        [_joined(F[None], -force) for F, force in zip(weight, pushed, strict=True)],
        [_joined(c[None], arm) for c, arm in zip(centre, arms, strict=True)],
    )
    tips = _tips(arms, [part[:3] for part in twist], spin, motion.rails)
    bent = _products("lian,libn->labn", tips, tips, 3)
    bent[0] = bent[0] - _extensions()
    by_links = _products("ln,labn->abn", _divided(link_n, _orders(motion.lengths)), bent, len(LINKS))
    by_turning = _products("ian,ibn->abn", spin, _products("ijn,jbn->ibn", turning, spin, 3), 3)
    return [turned - linked for turned, linked in zip(by_turning, by_links, strict=True)]


def _by_actuator(H: Series, rails: FloatArray) -> Series:
    """Write the right sides B (6, 5, n): u_l . d in the column of the link's cart, 1 in that of its telescope."""
    found = []
    for part in H:
        mid, rad = (np.zeros((len(LINKS), len(ACTUATORS), part.mid.shape[-1])) for _ in range(2))
        along = along_rails(part[:, :3], rails)
        mid[_EVERY, ARM_OF_LINK], rad[_EVERY, ARM_OF_LINK] = along.mid, along.rad
        found.append(Enclosure(mid, rad))
    found[0].mid[TELESCOPES, _EXTENDING] = 1.0
    return found


def _tips(arms: Series, velocity: Series, spin: Series, rails: FloatArray) -> Series:
    """Compute v + omega x A' - d cd for each link and actuator, each order (6, 3, 5, n)."""
    turned = _crossed([part[None] for part in spin], [part[:, :, None] for part in arms], axis=1)
    carts = np.zeros((len(LINKS), 3, len(ACTUATORS), 1))
    carts[_EVERY, :, ARM_OF_LINK] = rails[..., None]
    tips = [by_turn + part[None] for by_turn, part in zip(turned, velocity, strict=True)]
    return [tips[0] - exactly(carts), *tips[1:]]


def _extensions() -> Enclosure:
    """Write e_l' e_l of each link, shape (6, 5, 5, 1)."""
    squares = np.zeros((len(LINKS), len(ACTUATORS), len(ACTUATORS), 1))
    squares[TELESCOPES, _EXTENDING, _EXTENDING] = 1.0
    return exactly(squares)


def _turning(a: Series, b: Series) -> Series:
    """Sum S(a, b) = (a b' + b a') / 2 - (a . b) 1 over vectors (k, 3, n), each order (3, 3, n)."""
    found = []
    for part in _products("kin,kjn->ijn", a, b, len(LINKS) + 1):
        along = part[0, 0] + part[1, 1] + part[2, 2]
        identity = exactly(np.eye(3)[..., None])
        found.append((part + _transposed(part)) * exactly(0.5) - identity * along[None, None])
    return found


def _solved(A: Series, B: Series) -> Series:
    """Solve A X = B order by order, for matrices (6, 6, n) and (6, k, n): A0 Xn = Bn - A1 X(n-1) - ... - An X0."""
    inverse = exactly(np.moveaxis(np.linalg.inv(np.moveaxis(A[0].mid, -1, 0)), 0, -1))
    miss = (exactly(np.eye(6)[..., None]) - contract("ijn,jkn->ikn", inverse, A[0], 6)).magnitude
    found: Series = []
    for order, right in enumerate(B):
        for k in range(1, order + 1):
            right = right - contract("ijn,jkn->ikn", A[k], found[order - k], 6)
        found.append(_refined(contract("ijn,jkn->ikn", inverse, right, 6), miss))
    return found


def _refined(near: Enclosure, miss: FloatArray) -> Enclosure:
    """Enclose X = near + E X for |E| <= miss (6, 6, n): |X| <= |near| / (1 - ||miss||), column by column."""
    loss = total(*miss.swapaxes(0, 1)).max(axis=0)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        size = np.where(loss < 1.0, total(near.magnitude.max(axis=0) / total(1.0 - loss)), np.inf)
        each = total(near.magnitude, bound("ijn,kn->ikn", miss, size, 6))
        error = bound("ijn,jkn->ikn", miss, each, 6)
    return Enclosure(near.mid, np.where(np.isnan(error), np.inf, total(near.rad, error)))


def _products(subscripts: str, A: Series, B: Series, terms: int) -> Series:
    found = []
    for order in range(ORDERS):
        result = contract(subscripts, A[0], B[order], terms)
        for k in range(1, order + 1):
            result = result + contract(subscripts, A[k], B[order - k], terms)
        found.append(result)
    return found


def _crossed(a: Series, b: Series, axis: int) -> Series:
    found = []
    for order in range(ORDERS):
        result = cross(a[0], b[order], axis)
        for k in range(1, order + 1):
            result = result + cross(a[k], b[order - k], axis)
        found.append(result)
    return found


def _divided(a: Series, b: Series) -> Series:
    """Divide series: b0 xn = an - b1 x(n-1) - ... - bn x0."""
    inverse = b[0].inverse()
    found: Series = []
    for order, part in enumerate(a):
        for k in range(1, order + 1):
            part = part - b[k] * found[order - k]
        found.append(part * inverse)
    return found


def _constant(values: FloatArray, n: int) -> Series:
    same = np.repeat(values[:, None], n, axis=1)
    return [exactly(same), *(exactly(np.zeros_like(same)) for _ in range(ORDERS - 1))]


def _orders(series: Enclosure) -> Series:
    return [series[order] for order in range(ORDERS)]


def _joined(a: Enclosure, b: Enclosure) -> Enclosure:
    return Enclosure(np.concatenate([a.mid, b.mid]), np.concatenate([a.rad, b.rad]))


def _transposed(matrix: Enclosure) -> Enclosure:
    return Enclosure(matrix.mid.swapaxes(0, 1), matrix.rad.swapaxes(0, 1))
