"""Certificates of machines with bodies at the ends of links, with errors of the drives and without."""

from dataclasses import replace

import numpy as np

from pipeline.certify import prove_path
from pipeline.certify.chain import close_chain
from pipeline.certify.examiner import build_error_examiner
from pipeline.certify.problem import build_problem
from pipeline.certify.recheck import verify
from pipeline.certify.recheck.arithmetic.chain import evaluate_chain
from pipeline.certify.recheck.claims.distances.body_distances import body_distance_bounds as bounds_again
from pipeline.certify.result import proven_chain
from pipeline.config import Config
from pipeline.inclusion.closure import working_precision
from pipeline.inclusion.distances.bodies import body_distance_bounds
from pipeline.inclusion.proven_box import ProvenBox
from pipeline.inclusion.uncertainty import of_actuators
from pipeline.limits.bodies.body_distance import BODY_DISTANCE
from pipeline.limits.bodies.surface_distance import SurfaceDistance
from pipeline.machine import Machine
from pipeline.machine.bodies.distances import body_distances
from pipeline.machine.kinematics import newton
from pipeline.machine.samples import PoseSamples
from tests.certify.paths import START, ends_of, pose_path, state

OWN = {"stud", "motor", "ball", "collar"}
EPS_M, ENOUGH_M = 2e-4, 0.005


def test_what_is_proven_is_below_all_samples_and_verified(ends_config: Config, ends_machine: Machine, vary) -> None:
    """Of every pair with one of them, and by no more than some millimetres."""
    path = pose_path(ends_machine, np.linspace(START, [1.05, 0.33, 0.88, -0.05, 0.02], 41), 0)
    config, ends = vary(ends_config, {"certify.least_width": 4e-3}), ends_of(ends_machine, path, (0, 0))
    with working_precision(config.certify.precision_bits):
        found = prove_path(config, ends_machine, path, ends)
    assert found.failure is None
    assert found.bounds is not None
    s = np.linspace(0.0, 1.0, 501)
    least = body_distances(ends_machine.bodies, PoseSamples(ends_machine, path.pose(s), path.q(s))).min(axis=0)
    ranges = found.bounds.ranges["body_distance_m"]
    own = [k for k, name in enumerate(ranges.subjects) if OWN & set(name.split())]
    assert len(own) > 40
    assert (ranges.values[:, 0] <= least).all()
    np.testing.assert_allclose(ranges.values[own, 0], np.maximum(least[own], 0.0), atol=5e-3)
    claims = verify(config, ends_machine, path, ends, state(found))
    assert [claim.what for claim in claims if not claim.verified] == []


def test_drives_that_are_off_are_bounded(ends_machine: Machine) -> None:
    """Telescopes that are longer or shorter move what is on them: all corners of the errors are above both bounds."""
    path = pose_path(ends_machine, np.linspace(START, START + [1e-3, 1e-3, 0.0, 0.0, 0.0], 8), 0, nodes=8)
    boxes: list[ProvenBox] = []

    def keep(box: ProvenBox) -> tuple[()]:
        boxes.append(box)
        return ()

    kind = of_actuators(np.ones(5))(EPS_M)
    with working_precision(64):
        chain = close_chain(build_problem(ends_machine, path, 0.05, kind), keep)
        assert chain.failure is None
        bodies = ends_machine.bodies
        assert bodies is not None
        sharp = np.array([body_distance_bounds(box, bodies) for box in boxes])
        rough = np.array([body_distance_bounds(box, bodies, ENOUGH_M) for box in boxes])
        far = SurfaceDistance(bodies, BODY_DISTANCE, "body distance", "bodies")
        near = replace(far, bodies=replace(bodies, clearance_m=0.015))
        for limit in (far, near):
            examine = build_error_examiner([limit])
            # Asked twice: what refused a box before is asked first.
            verdicts = [examine(box) == () for box in boxes for _ in range(2)]
            assert all(verdicts) == (limit is far)
            assert verdicts == [limit.unproven(limit.bound(box)) == "" for box in boxes for _ in range(2)]
    proven = sharp.min(axis=0)
    # Where pairs are far apart bounds need not be sharp; nothing is lost of what is asked.
    assert (rough[sharp >= ENOUGH_M] >= ENOUGH_M).all()
    assert (rough < sharp).any()
    (segment,) = evaluate_chain(ends_machine, path, proven_chain(chain, kind, within_limits=True))
    off = segment.displacement(ends_machine), segment.erring(ends_machine)
    again = bounds_again(ends_machine, bodies, segment.boxes, off).min(axis=1)
    s, signs = np.linspace(0.0, 1.0, 5), np.array(np.meshgrid(*[[-1.0, 1.0]] * 5)).reshape(5, -1).T
    q = (path.q(s)[:, None] + EPS_M * signs).reshape(-1, 5)
    pose, _ = newton(ends_machine, q, np.repeat(path.pose(s), len(signs), axis=0))
    sampled = body_distances(bodies, PoseSamples(ends_machine, pose, q)).min(axis=0)
    own = [k for k, name in enumerate(bodies.names) if OWN & set(name.split())]
    apart = np.array(own)[sampled[own] > 0.0]
    assert (rough.min(axis=0) <= sampled).all()
    for bounds in (proven, again):
        assert (bounds <= sampled).all()
        assert (bounds[apart] >= sampled[apart] - 4e-3).all()
