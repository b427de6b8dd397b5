"""Bounds of kappa box by box."""

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest

from pipeline.certify import Certificate
from pipeline.certify.recheck import kappa_profile
from pipeline.certify.result import ProvenChain
from pipeline.machine import Machine
from pipeline.refine import Path
from pipeline.refine.motion import kappa_along


@pytest.fixture(scope="module")
def certificate(machine: Machine, line: Path, prove: Callable[..., Certificate]) -> Certificate:
    """Certify the short path."""
    return prove(machine, line)


def test_bounds_are_above_kappa_in_every_box(machine: Machine, line: Path, certificate: Certificate) -> None:
    """Boxes reach from 0 to 1; whatever is sampled within one is below its bound, which is near the certificate's."""
    profile = kappa_profile(machine, line, certificate.chain)
    assert (profile.edges[0], profile.edges[-1]) == (0.0, 1.0)
    assert (np.diff(profile.edges) > 0.0).all()
    for a, b, bound in zip(profile.edges[:-1], profile.edges[1:], profile.kappa, strict=True):
        assert kappa_along(line, np.linspace(a, b, 21)).max() <= bound
    assert certificate.bounds is not None
    assert profile.kappa.max() == pytest.approx(certificate.bounds.kappa, rel=0.05)


def test_a_box_that_proves_nothing_bounds_nothing(machine: Machine, line: Path, certificate: Certificate) -> None:
    """A box moved off the path is not proven, and its bound is infinite; the others keep theirs."""
    first, *rest = certificate.chain.boxes
    moved = dataclasses.replace(first, pose=first.pose + 0.05 * (np.arange(4)[:, None] == 0))
    profile = kappa_profile(machine, line, ProvenChain(certificate.chain.uncertainty, (moved, *rest), ()))
    good = kappa_profile(machine, line, certificate.chain)
    assert profile.kappa[0] == np.inf
    np.testing.assert_array_equal(profile.kappa[1:], good.kappa[1:])
