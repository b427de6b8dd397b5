"""What forces leave for motion: one at the limit, and four times less in twice the time."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.refine.result import Path
from pipeline.retime.force_shares import moving_shares
from pipeline.retime.path_dynamics import Terms, path_terms
from pipeline.retime.quantities import limits


@pytest.fixture(scope="module")
def terms(path: Path) -> Terms:
    """The curve with friction, at places all along it."""
    masses = replace(path.machine.masses, friction_n=np.full(5, 20.0))
    return path_terms(replace(path, machine=replace(path.machine, masses=masses)), np.linspace(0.02, 0.98, 60))


@pytest.mark.parametrize("w", [-1.5, 0.7])
def test_a_share_of_one_is_the_limit(terms: Terms, w: float) -> None:
    """A force is above its limit where the share is above one, and nowhere else."""
    v, w_all = np.full(60, 0.3), np.full(60, w)
    values = terms.values(v, w_all, 0.0 * v)
    force = np.array([120.0, 120.0, 120.0, 450.0, 450.0])
    weak = replace(terms, machine=replace(terms.machine, force_n=force, link_force_n=450.0))
    allowed = limits(weak.machine)
    for name, share in moving_shares(weak, values).items():
        held = np.abs(terms.resting()[name]) < allowed[name]
        assert np.array_equal((share > 1.0)[held], (np.abs(values[name]) > allowed[name])[held])


def test_time_stretched_by_two_takes_a_quarter(terms: Terms) -> None:
    """Motion's part of a force falls with the square of the time it has."""
    v, w = np.full(60, 0.3), np.full(60, 0.7)
    one = moving_shares(terms, terms.values(v, w, 0.0 * v))
    other = moving_shares(terms, terms.values(v / 2.0, w / 4.0, 0.0 * v))
    for name, share in one.items():
        assert other[name] == pytest.approx(share / 4.0)


def test_without_room_or_without_a_limit(terms: Terms) -> None:
    """Where rest takes all there is, the share of any motion is infinite; where there is no limit it is zero."""
    v, w = np.full(60, 0.3), np.full(60, 0.7)
    values = terms.values(v, w, 0.0 * v)
    force = np.array([1e-6, np.inf, np.inf, np.inf, np.inf])
    share = moving_shares(replace(terms, machine=replace(terms.machine, force_n=force)), values)["force"]
    assert np.isinf(share[:, 0]).any()
    assert not share[:, 1:].any()
