"""The proof for all machines of an ellipsoid: two claims, and where each of them ends."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from pipeline.certify.machines.calibrated import CalibratedProof, prove_calibrated
from pipeline.certify.recheck import StatedMachines, Statement
from pipeline.certify.recheck.arithmetic.chain import evaluate_chain
from pipeline.certify.recheck.claims import chain, machines
from pipeline.certify.recheck.claims.inventory import MACHINES, inventory_claims
from pipeline.config import Config
from pipeline.machine import Machine
from pipeline.machine.samples import PoseSamples
from pipeline.refine import Path
from tests.certify.paths import START, pose_path
from tests.certify.possible import Machines, on_the_sphere, some_ellipsoid
from tests.rails import off_x

_STD_M = 5e-5


@pytest.fixture(scope="module")
def line(machine: Machine) -> Path:
    """Go a short way in two pieces."""
    return pose_path(machine, np.linspace(START, [1.05, 0.33, 0.88, 0.05, -0.02], 7), 0, nodes=7)


@pytest.fixture(scope="module")
def prove_machines(wide: Config, line: Path) -> Callable[..., CalibratedProof]:
    """Give a function that proves the short path for some machines, with a cap on kappa."""

    def run(sigma: float, kappa_max: float = 1e9) -> CalibratedProof:
        config = wide.model_copy(update={"route": wide.route.model_copy(update={"kappa_max": kappa_max})})
        return prove_calibrated(config, line.machine, line, some_ellipsoid(_STD_M, sigma))

    return run


@pytest.fixture(scope="module")
def largest_kappa(line: Path) -> float:
    """Compute the largest kappa at samples."""
    s = np.linspace(0.0, 1.0, 201)
    return float(PoseSamples(line.machine, line.pose(s), line.q(s)).kappa.max())


def test_limits_are_kept_or_else_the_branch(
    prove_machines: Callable[..., CalibratedProof], largest_kappa: float
) -> None:
    """A cap just above the path's kappa leaves no room for other machines, and says where."""
    kept, broken = prove_machines(3.0, 2.0 * largest_kappa), prove_machines(3.0, 1.0001 * largest_kappa)
    assert kept.chain is not None
    assert kept.chain.within_limits
    assert kept.broken is None
    assert broken.chain is not None
    assert not broken.chain.within_limits
    assert broken.broken is not None
    assert "kappa" in broken.broken.reason.text
    assert broken.failure is None


def test_many_deviations_are_not_proven(prove_machines: Callable[..., CalibratedProof]) -> None:
    """With where and why; and the more deviations, the more boxes and reserve."""
    few, more, most = (prove_machines(sigma) for sigma in (1.0, 6.0, 300.0))
    assert few.chain is not None
    assert more.chain is not None
    assert len(few.chain.boxes) <= len(more.chain.boxes)
    assert (np.array(few.reserves.actuators_m) * 5.9 < more.reserves.actuators_m).all()
    assert most.chain is None
    assert most.failure is not None
    assert most.reserves.tilt_deg == ()


def test_ten_thousand_machines_are_in_their_boxes(line: Path, prove_machines: Callable[..., CalibratedProof]) -> None:
    """Followed along the path: about x - C e with the e of each, and within what is in reserve."""
    proof, ellipsoid, machine = prove_machines(3.0), some_ellipsoid(_STD_M), line.machine
    assert proof.chain is not None
    u = on_the_sphere(ellipsoid, 10_000)
    u[5_000:] *= np.random.default_rng(3).uniform(size=(5_000, 1)) ** (1.0 / u.shape[1])
    for k, box in enumerate(proof.chain.boxes):
        u = u if k == 0 else u[4_500:5_500]
        s = (box.first + box.last) / 2.0
        many, plain = (Machines.at(machine, ellipsoid, part, line.q(s)) for part in (u, 0.0 * u[:1]))
        x = box.pose[0]
        e = many.residuals(np.tile(x, (len(u), 1))) - plain.residuals(x[None])
        poses = many.assembled(line.pose(s))
        off = poses - x + e @ np.linalg.inv(plain.jacobian(x[None])[0]).T
        assert (np.abs(off) <= box.radius).all()
        tilts = np.rad2deg(np.abs(poses - line.pose(s)).max(axis=0)[[3, 5]])
        assert (tilts <= proof.reserves.tilt_deg).all()
        assert (np.abs(many.actuators - line.q(s)).max(axis=0) <= proof.reserves.actuators_m).all()


def test_other_arithmetic_verifies_the_boxes(line: Path, prove_machines: Callable[..., CalibratedProof]) -> None:
    """All of them, their joints, and what is in reserve; not for twice as many deviations."""
    proof = prove_machines(6.0)
    assert proof.chain is not None
    (segment,) = evaluate_chain(line.machine, line, proof.chain)
    assert chain.count_boxes(segment).all_hold
    stated = np.array([*proof.reserves.tilt_deg, *proof.reserves.actuators_m])
    assert (machines.off_path(line.machine, segment) <= stated).all()
    twice = replace(proof.chain.uncertainty, ellipsoid=some_ellipsoid(_STD_M, 12.0))
    (segment,) = evaluate_chain(line.machine, line, replace(proof.chain, uncertainty=twice))
    assert not chain.count_boxes(segment).all_hold


def test_nothing_is_verified_of_rails_off_x(line: Path, prove_machines: Callable[..., CalibratedProof]) -> None:
    """What is stated of the same machines is a claim about parallel rails alone."""
    proof = prove_machines(3.0)
    assert proof.chain is not None
    said = StatedMachines(3.0, 12, 0.5, len(proof.chain.boxes), True, "", (), (), (), False)
    stated = Statement("", "", 0, None, None, None, (proof.chain, proof.chain), machines=said)  # type: ignore[arg-type]
    for machine, kept in ((line.machine, True), (off_x(line.machine, largest=1e-6), False)):
        (claim,) = (one for one in inventory_claims(machine, stated) if one.what == MACHINES)
        assert claim.verified == kept
