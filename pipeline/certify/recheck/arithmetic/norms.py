"""Upper bounds of norms, for many boxes at a time."""

from pipeline.arrays import FloatArray
from pipeline.certify.recheck.arithmetic.enclosure import bound, root, times, total
from pipeline.machine.geometry import Machine


def norm(bounds: FloatArray) -> FloatArray:
    """Bound the Euclidean norm over the first axis."""
    return root(total(*(bounds**2)))


def frobenius(bounds: FloatArray) -> FloatArray:
    """Bound the Frobenius norm of matrices (6, 6, n). Shape (n,)."""
    return root(bound("ijn,ijn->n", bounds, bounds, terms=36))


def arm_lengths(machine: Machine) -> FloatArray:
    """Bound the distances of the platform joints from the TCP. Shape (6,)."""
    return norm(machine.platform_points_m.T)


def joint_shift(machine: Machine, deviation: FloatArray) -> FloatArray:
    """Bound how far each platform joint moves as the pose deviates by (6, ...). Shape (6, ...).

    No Euler angle moves a joint farther than its distance from the TCP times the angle.
    """
    turn = total(*deviation[3:])
    arms = arm_lengths(machine).reshape(-1, *(1,) * turn.ndim)
    return total(norm(deviation[:3])[None], times(arms, turn))
