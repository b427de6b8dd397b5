"""The forces that hold the machine: of drives, and along links."""

from collections.abc import Iterator

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.bounds import Bounds
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
from pipeline.certify.recheck.arithmetic.norms import frobenius, norm
from pipeline.certify.recheck.arithmetic.ranges import polynomial_ranges
from pipeline.certify.recheck.claims.claim import Claim
from pipeline.certify.recheck.claims.evidence import Evidence, upper_bounds
from pipeline.certify.recheck.claims.kappa import statics_change
from pipeline.limits.holding_force import SUBJECTS
from pipeline.machine.geometry import ARM_OF_LINK, TELESCOPES, Machine
from pipeline.machine.masses import Masses, lumped_platform

FORCES = "drives and links hold the machine within their limits"
CLAIMS: tuple[str, ...] = (FORCES,)
KEYS: tuple[str, ...] = ("holding_force_n",)


def measure(machine: Machine, segment: EvaluatedChain) -> FloatArray:
    """Bound all holding forces over some boxes; none where no forces are limited."""
    if machine.masses is None or np.isinf(_limits(machine)).all():
        return np.empty((0, 2))
    return upper_bounds(holding_force_bounds(machine, machine.masses, segment.boxes, segment.inclusions.image))


def _limits(machine: Machine) -> FloatArray:
    return np.concatenate([machine.force_n, np.full(6, machine.link_force_n)])


def check(evidence: Evidence, stated: Bounds) -> Iterator[Claim]:
    """Verify the bounds of all holding forces for every s, if the machine has masses and force limits."""
    machine, masses, most = evidence.machine, evidence.machine.masses, evidence.largest
    if masses is None or not len(most):
        yield Claim(FORCES, verified=KEYS[0] not in stated.ranges, found="no forces are limited")
        return
    if KEYS[0] not in stated.ranges:
        yield Claim(FORCES, verified=False, found="not stated: certified before forces were bounded")
        return
    allowed = machine.holding_fraction * _limits(machine) + np.append(masses.friction_n, np.zeros(6))
    bounds = stated.ranges[KEYS[0]].values[:, 1]
    kept = (most <= bounds) & (bounds <= allowed)
    shown = int(np.argmax(most / allowed) if kept.all() else np.argmin(kept))
    yield Claim(
        FORCES,
        bool(kept.all()),
        f"{SUBJECTS[shown]} {most[shown]:.5g}, stated {bounds[shown]:.5g}, allowed {allowed[shown]:.5g} N",
    )


def holding_force_bounds(machine: Machine, masses: Masses, boxes: Boxes, deviation: FloatArray) -> FloatArray:
    """Bound the magnitudes of all forces over all boxes, for poses within `deviation` (6, n) of the cubics. (11,).

    The statement is that of `pipeline.inclusion.forces`.
    """
    at, over, h = boxes.at.statics(), boxes.over.statics(), boxes.half
    H = [_transposed(part) for part in (at[0], at[1], over[2])]
    Y = [exactly(part) for part in linear_inverse(H)]
    miss = residual_of_inverse(Y, H, h)
    off = statics_change(machine, boxes, deviation)
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
    rows = [(over if n + 1 == TERMS else at)[n][:, 0] for n in range(TERMS)]
    along_x = _magnitudes(stacked(rows), h)
    carts, cart_errors = [], []
    for arm in range(3):
        of = np.flatnonzero(arm == ARM_OF_LINK)
        carts.append(_summed_products(links[:, of], [row[of] for row in rows]))
        cart_errors.append(total(*times(errors[of], total(along_x[of], off[None])), *([times(size, off)] * len(of))))
    found = np.concatenate(
        [
            total(_ranges(stacked(carts, 1), h), np.stack(cart_errors)),
            total(_ranges(links[:, TELESCOPES], h), errors[TELESCOPES]),
            total(_ranges(links, h), errors),
        ]
    )
    return np.asarray(found.max(axis=1), dtype=float)


def _wrenches(machine: Machine, masses: Masses, boxes: Boxes, deviation: FloatArray) -> tuple[Enclosure, FloatArray]:
    """Compute (F, r x F) along the cubics, (orders, 6, n), and bound how far it changes with the pose of a box (n,)."""
    body = lumped_platform(masses, machine.platform_points_m)
    x, y, z = F = -body.mass_kg * masses.gravity_mps2
    turned = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    at, over = (
        contract("oijn,j->oin", motion.rotation, exactly(body.centre_m), 3) for motion in (boxes.at, boxes.over)
    )
    arms = stacked([(over if n + 1 == TERMS else at)[n] for n in range(TERMS)])
    moments = contract("ij,ojn->oin", exactly(turned), arms, 3)
    forces = np.zeros_like(moments.mid)
    forces[0] = F[:, None]
    mid, rad = (
        np.concatenate(parts, axis=1) for parts in ((forces, moments.mid), (np.zeros_like(forces), moments.rad))
    )
    arm, force = norm(np.abs(body.centre_m)[:, None]), norm(np.abs(F)[:, None])
    return Enclosure(mid, rad), times(arm, force, total(*deviation[3:]))


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


def _ranges(series: Enclosure, half: FloatArray) -> FloatArray:
    least, largest = polynomial_ranges(series, half)
    return np.maximum(-least, largest)


def _transposed(matrix: Enclosure) -> Enclosure:
    return Enclosure(matrix.mid.swapaxes(0, 1), matrix.rad.swapaxes(0, 1))


def _joined(a: Enclosure, b: Enclosure) -> Enclosure:
    return Enclosure(np.concatenate([a.mid, b.mid]), np.concatenate([a.rad, b.rad]))
