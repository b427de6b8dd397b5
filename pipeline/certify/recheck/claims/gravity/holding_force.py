"""The forces that hold the machine: of drives, and along links."""

from collections.abc import Iterator

import numpy as np

from pipeline.arrays import BoolArray, FloatArray
from pipeline.certify.bounds import Bounds
from pipeline.certify.recheck.arithmetic.calibrated.displacement import of_pose
from pipeline.certify.recheck.arithmetic.chain import EvaluatedChain
from pipeline.certify.recheck.arithmetic.enclosure import (
    Enclosure,
    bound,
    contract,
    exactly,
    root,
    stacked,
    times,
    total,
)
from pipeline.certify.recheck.arithmetic.inclusion import Boxes, linear_inverse, power, residual_of_inverse
from pipeline.certify.recheck.arithmetic.jets import TERMS
from pipeline.certify.recheck.arithmetic.loads.dynamics import cart_weights, with_constant
from pipeline.certify.recheck.arithmetic.motion import along_rails
from pipeline.certify.recheck.arithmetic.norms import frobenius, norm
from pipeline.certify.recheck.arithmetic.ranges import polynomial_ranges
from pipeline.certify.recheck.claims.claim import Claim
from pipeline.certify.recheck.claims.evidence import Evidence
from pipeline.certify.recheck.claims.kappa import statics_change
from pipeline.config import Config
from pipeline.limits.holding_force import SUBJECTS
from pipeline.machine.geometry import ARM_OF_LINK, TELESCOPES, Machine
from pipeline.machine.masses import Masses, lumped_platform

FORCES = "drives and links hold the machine within their limits"
CLAIMS: tuple[str, ...] = (FORCES,)
KEYS: tuple[str, ...] = ("holding_force_n",)


def measure(config: Config, machine: Machine, segment: EvaluatedChain) -> FloatArray:
    """Bound all holding forces over some boxes; none where no forces are limited."""
    if machine.masses is None or np.isinf(machine.force_limits_n).all():
        return np.empty((0, 2))
    return holding_force_bounds(machine, machine.masses, segment.boxes, segment.inclusions.image)


def check(evidence: Evidence, stated: Bounds) -> Iterator[Claim]:
    """Verify the bounds of all holding forces for every s, if the machine has masses and force limits."""
    machine, masses, found = evidence.machine, evidence.machine.masses, evidence.found
    if masses is None or not len(found):
        yield Claim(FORCES, verified=KEYS[0] not in stated.ranges, found="no forces are limited")
        return
    if KEYS[0] not in stated.ranges:
        yield Claim(FORCES, verified=False, found="not stated: certified before forces were bounded")
        return
    # Push is positive.
    push, pull = machine.holding_fraction * machine.force_limits_n + np.append(masses.friction_n, np.zeros(6))
    allowed, bounds = np.column_stack([-pull, push]), stated.ranges[KEYS[0]].values
    kept = _within(found, bounds) & _within(bounds, allowed)
    shown = int(np.argmax((found / allowed).max(axis=1)) if kept.all() else np.argmin(kept))
    names = zip(("", "stated ", "allowed "), (found, bounds, allowed), strict=True)
    spans = (f"{name}{least:.5g} to {most:.5g}" for name, (least, most) in ((name, of[shown]) for name, of in names))
    yield Claim(FORCES, bool(kept.all()), f"{SUBJECTS[shown]} {', '.join(spans)} N")


def _within(ranges: FloatArray, of: FloatArray) -> BoolArray:
    """Check which ranges (m, 2) lie within others. Shape (m,)."""
    return np.asarray((of[:, 0] <= ranges[:, 0]) & (ranges[:, 1] <= of[:, 1]), dtype=bool)


def holding_force_bounds(machine: Machine, masses: Masses, boxes: Boxes, deviation: FloatArray) -> FloatArray:
    """Bound all forces over all boxes, for poses within `deviation` (6, n) of the cubics. Shape (11, 2).

    The statement is that of `pipeline.inclusion.gravity.forces`.
    """
    at, over, h = boxes.at.statics(), boxes.over.statics(), boxes.half
    H = [_transposed(part) for part in (at[0], at[1], over[2])]
    Y = [exactly(part) for part in linear_inverse(H)]
    miss = residual_of_inverse(Y, H, h)
    off = statics_change(machine, boxes.over, of_pose(machine, deviation))
    bound_Y = total(frobenius(Y[0].magnitude), times(h, frobenius(Y[1].magnitude)))
    loss = total(frobenius(miss), times(bound_Y, off))
    wrench, turned_by = _wrenches(machine, masses, boxes, deviation)
    links = _polynomials(Y, wrench)
    moved_by = times(bound_Y, turned_by)
    with np.errstate(divide="ignore", invalid="ignore"):
        size = np.where(loss < 1.0, total(total(norm(_magnitudes(links, h)), moved_by) / (1.0 - loss)), np.inf)
    by_pose = total(times(bound_Y, off, size), moved_by)
    errors = total(times(root(bound("ijn,ijn->in", miss, miss, terms=6)), size), by_pose[None])
    each = total(_magnitudes(links, h), errors)
    errors = total(bound("ijn,jn->in", miss, each, terms=6), by_pose[None])
    rails, weights = boxes.at.rails, cart_weights(machine, masses)
    rows = [along_rails((over if n + 1 == TERMS else at)[n][:, :3], rails) for n in range(TERMS)]
    along, change = _magnitudes(stacked(rows), h), times(norm(np.abs(rails).T).max(), off)
    carts, cart_errors = [], []
    for arm in range(3):
        of = np.flatnonzero(arm == ARM_OF_LINK)
        carts.append(with_constant(_summed_products(links[:, of], [row[of] for row in rows]), weights[arm]))
        cart_errors.append(
            total(*times(errors[of], total(along[of], change[None])), *([times(size, change)] * len(of)))
        )
    parts = ((stacked(carts, 1), np.stack(cart_errors)), (links[:, TELESCOPES], errors[TELESCOPES]), (links, errors))
    return np.concatenate([_range(forces, h, error) for forces, error in parts])


def _wrenches(machine: Machine, masses: Masses, boxes: Boxes, deviation: FloatArray) -> tuple[Enclosure, FloatArray]:
    """Compute (F, r x F / L) along the cubics, (orders, 6, n), and bound its change with the pose of a box (n,).

    L is the characteristic length.
    """
    body = lumped_platform(masses, machine.platform_points_m)
    x, y, z = F = -body.mass_kg * masses.gravity_mps2
    turned = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    at, over = (
        contract("oijn,j->oin", motion.rotation, exactly(body.centre_m), 3) for motion in (boxes.at, boxes.over)
    )
    arms = stacked([(over if n + 1 == TERMS else at)[n] for n in range(TERMS)])
    moments = contract("ij,ojn->oin", exactly(turned), arms, 3) * exactly(machine.characteristic_length_m).inverse()
    forces = np.zeros_like(moments.mid)
    forces[0] = F[:, None]
    mid, rad = (
        np.concatenate(parts, axis=1) for parts in ((forces, moments.mid), (np.zeros_like(forces), moments.rad))
    )
    arm, force = norm(np.abs(body.centre_m)[:, None]), norm(np.abs(F)[:, None])
    turned_by = total(times(arm, force, total(*deviation[3:])) / machine.characteristic_length_m)
    return Enclosure(mid, rad), turned_by


def _polynomials(Y: list[Enclosure], vectors: Enclosure) -> Enclosure:
    """Multiply Y0 + Y1 t by vectors (orders, 6, n). Shape (orders + 1, 6, n)."""
    constant = contract("ijn,ojn->oin", Y[0], vectors, 6)
    linear = contract("ijn,ojn->oin", Y[1], vectors, 6)
    none = exactly(np.zeros_like(constant.mid[:1]))
    return _joined(constant, none) + _joined(none, linear)


def _summed_products(forces: Enclosure, rows: list[Enclosure]) -> Enclosure:
    """Multiply polynomials (orders, links, n) by others and sum over links. Shape (orders, n)."""
    orders = len(forces.mid) + len(rows) - 1
    found = [exactly(np.zeros_like(rows[0].mid[0])) for _ in range(orders)]
    for i in range(len(forces.mid)):
        for j, row in enumerate(rows):
            found[i + j] = found[i + j] + contract("ln,ln->n", forces[i], row, row.mid.shape[0])
    return stacked(found)


def _magnitudes(series: Enclosure, half: FloatArray) -> FloatArray:
    return total(*(bound("...n,n->...n", term, power(half, n), terms=1) for n, term in enumerate(series.magnitude)))


def _range(series: Enclosure, half: FloatArray, errors: FloatArray) -> FloatArray:
    """Bound polynomials (orders, m, n) with errors (m, n) over all boxes from below and above. Shape (m, 2)."""
    least, largest = polynomial_ranges(series, half)
    return np.column_stack([Enclosure(least, errors).lower.min(axis=1), Enclosure(largest, errors).upper.max(axis=1)])


def _transposed(matrix: Enclosure) -> Enclosure:
    return Enclosure(matrix.mid.swapaxes(0, 1), matrix.rad.swapaxes(0, 1))


def _joined(a: Enclosure, b: Enclosure) -> Enclosure:
    return Enclosure(np.concatenate([a.mid, b.mid]), np.concatenate([a.rad, b.rad]))
