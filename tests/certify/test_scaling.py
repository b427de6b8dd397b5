"""Machines of any size are proven with the same kappa."""

import numpy as np
import pytest

from pipeline.certify import prove_path
from pipeline.certify.recheck.arithmetic.chain import evaluate_chain
from pipeline.certify.recheck.claims.kappa import kappa_bounds
from pipeline.config import Config
from pipeline.inclusion.closure import working_precision
from pipeline.machine import build_machine
from tests.certify.paths import START, ends_of, pose_path
from tests.scaling import scaled


def test_certificates_are_the_same(wide: Config):
    """A short path has the same bound of kappa, and is held by the same forces, in both arithmetics."""
    bounds = []
    for size in (1.0, 0.13, 3.7):
        config = scaled(wide, size)
        machine = build_machine(config.machine)
        line = np.linspace(START, [1.05, 0.33, 0.88, 0.05, -0.02], 41) * np.array([size, size, size, 1.0, 1.0])
        path = pose_path(machine, line, 0)
        with working_precision(config.certify.precision_bits):
            certificate = prove_path(config, machine, path, ends_of(machine, path, (0, 0)))
        assert certificate.verdict == "certified"
        (chain,) = evaluate_chain(machine, path, certificate.chain)
        kappa, sign = kappa_bounds(machine, chain.boxes, chain.displacement(machine))
        assert (sign == certificate.bounds.det_sign).all()
        forces = certificate.bounds.ranges["holding_force_n"].values
        bounds.append((certificate.bounds.kappa, float(kappa.max()), forces))
    (proven, checked, forces), *others = bounds
    for other_proven, other_checked, other_forces in others:
        assert other_proven == pytest.approx(proven, rel=5e-3)
        assert other_checked == pytest.approx(checked, rel=5e-3)
        np.testing.assert_allclose(other_forces, forces, atol=0.02 * np.abs(forces).max())
