"""A motion as polynomials: the same positions as floats give, without their rounding."""

import numpy as np
from flint import arb, arb_poly, fmpq

from pipeline.inclusion.closure import working_precision
from pipeline.retime import Trajectory
from pipeline.retime.proof.exact_motion import about, exact_motion


def test_positions_are_those_of_the_trajectory(curved: Trajectory) -> None:
    """At instants all along the motion, on the pieces that hold their s."""
    with working_precision(96):
        motion = exact_motion(curved)
        (piece,) = motion.law
        for t in np.linspace(0.0, curved.duration_s, 41):
            s = about(piece, fmpq(*float(t).as_integer_ratio()))
            of = motion.covering(s(arb(0)))[-1]
            found = [float(motion.position(of, k, s)(arb(0)).mid()) for k in range(5)]
            np.testing.assert_allclose(found, curved.q(t), atol=1e-13)


def test_at_a_knot_both_pieces_are_met_and_beyond_the_ends_the_nearest(curved: Trajectory) -> None:
    """A ball about a knot reaches into both; the first and the last piece reach on."""
    with working_precision(96):
        motion = exact_motion(curved)
    knot = motion.firsts[3]
    assert list(motion.covering(arb(knot, 1e-9))) == [2, 3]
    assert list(motion.covering(arb(-1e-9))) == [0]
    assert list(motion.covering(arb(1.0 + 1e-9))) == [len(motion.path) - 1]


def test_expansions_are_about_the_time_asked_for(curved: Trajectory) -> None:
    """Their constant term is s there, and their slope its rate."""
    with working_precision(96):
        s = about(exact_motion(curved).law[0], fmpq(1))
    assert isinstance(s, arb_poly)
    np.testing.assert_allclose([float(s[k].mid()) for k in range(2)], [curved.s(1.0), curved.s(1.0, 1)], rtol=1e-14)
