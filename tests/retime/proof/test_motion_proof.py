"""The proof of a motion: what keeps its limits passes, what does not is refused with the place."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import PPoly

from pipeline.errors import NoSolutionError
from pipeline.retime import Trajectory, law_sha256, prove_motion, require_proven, time_reversed
from pipeline.retime.result import stretched
from tests.retime.proof.conftest import of_degree_two, with_bump, with_corner, with_locked


def test_a_motion_within_its_limits_is_proven(straight: Trajectory) -> None:
    """No more than its limits, and no longer for it."""
    proof = require_proven(straight)
    assert proof.stretch == 1.0
    assert proof.leaves_path_s is None
    assert set(proof.fractions) == {"velocity", "acceleration", "jerk"}


def test_a_spike_of_a_tenth_of_a_millisecond_is_refused_where_it_is(straight: Trajectory) -> None:
    """Whatever samples of a controller's period see of it."""
    with pytest.raises(NoSolutionError, match=r"c1 is not proven to keep its jerk limit .* t = 1\.234\d s") as refused:
        require_proven(with_bump(straight, 1.2345, 1e-4, 1e-11))
    assert refused.value.diagnosis["limit"] == "jerk"


def test_on_the_way_back_s_is_that_of_the_way_there(straight: Trajectory) -> None:
    """The same instant, counted from the other end."""
    back = time_reversed(with_bump(straight, 1.2345, 1e-4, 1e-11))
    with pytest.raises(NoSolutionError) as refused:
        require_proven(back, backwards=True)
    assert refused.value.diagnosis["s"] == pytest.approx(float(straight.s(1.23455)), abs=1e-4)
    assert refused.value.diagnosis["t_s"] == pytest.approx(straight.duration_s - 1.23455, abs=1e-4)


def test_the_stretch_is_what_is_missing_and_no_more(straight: Trajectory) -> None:
    """A motion that is 1 % too fast is proven once it takes that longer, to within a thousandth."""
    hurried = stretched(straight, 0.99 * straight.duration_s)
    with pytest.raises(NoSolutionError, match="not proven"):
        require_proven(hurried)
    factor = prove_motion(hurried).stretch
    assert factor == pytest.approx(1.0 / 0.99, rel=2e-3)
    require_proven(stretched(hurried, factor * hurried.duration_s))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda c: c * (1.0 - 1e-6), "position of an actuator jumps"),
        (lambda c: c + 1e-3 * np.array([[0.0, 0.0, 0.0, 1.0, -4.0, 0.0]]).T, "leaves the path"),
        (lambda c: c * (1.0 + 1e-6), "leaves the path"),
    ],
)
def test_a_law_that_is_not_one_motion_is_refused(straight: Trajectory, change, words: str) -> None:
    """Jumps from rest, and ends beyond the path."""
    law = straight.time_law
    with pytest.raises(NoSolutionError, match=words):
        require_proven(replace(straight, time_law=PPoly(change(law.c), law.x)))


@pytest.mark.parametrize("multiplicity", [4, 5])
def test_a_corner_of_the_path_is_refused(straight: Trajectory, multiplicity: int) -> None:
    """In the middle of a piece of the law, where no coefficients of the law tell of it."""
    require_proven(with_corner(straight, 3))
    with pytest.raises(NoSolutionError, match=r"curvature jumps at s = 0\.5000"):
        require_proven(with_corner(straight, multiplicity))


def test_accelerations_jump_only_where_jerk_is_not_to_be_limited(straight: Trajectory) -> None:
    """A law of degree two is no excuse."""
    abrupt = of_degree_two(straight, 60.0)
    assert "jerk" not in require_proven(abrupt, jerk=False).fractions
    with pytest.raises(NoSolutionError, match="the acceleration of an actuator jumps"):
        require_proven(abrupt)


def test_a_locked_actuator_that_moves_is_refused(straight: Trajectory) -> None:
    """Telescopes stand still, carts do not."""
    require_proven(with_locked(straight, 3))
    with pytest.raises(NoSolutionError, match="c2 has to move"):
        require_proven(with_locked(straight, 1))


def test_the_hash_is_of_law_path_and_waiting(straight: Trajectory) -> None:
    """One bit of any of them changes it."""
    law, path = straight.time_law, straight.path
    spline = path.spline
    moved = type(spline)(spline.t, np.nextafter(spline.c, 9.0), spline.k)
    others = (
        replace(straight, time_law=PPoly(np.nextafter(law.c, 9.0), law.x)),
        replace(straight, time_law=PPoly(law.c, np.nextafter(law.x, 9.0) * [0.0, 1.0])),
        replace(straight, dwell_s=(0.01, 0.0)),
        replace(straight, path=replace(path, spline=moved)),
    )
    assert len({law_sha256(motion) for motion in (straight, *others)}) == 5
