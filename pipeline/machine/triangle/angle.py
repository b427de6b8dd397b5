"""The dependent angle ry: what the rigid triangle of links 3a and 3c does to the platform.

On the axis, see `closure`, there is a closed form. Otherwise cart 3 moves along with ry: Newton's method starts at the
closed form of the machine moved onto the axis, and a bracketed search over a full turn takes what is left. Where
|C| = hypot(A, B) two solutions meet and the machine may change from one assembly branch to the other; without tilt
the right-angled triangle has a Type-II singularity there.
"""

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.machine.geometry import Machine
from pipeline.machine.triangle.closure import closed_form, on_axis
from pipeline.machine.triangle.newton import nearest_root
from pipeline.machine.triangle.search import root_search

_BLOCK = 20_000


def dependent_angle(machine: Machine, controlled: FloatArray, signs: FloatArray) -> FloatArray:
    """Compute ry in (-pi, pi] on the machine's assembly branch; NaN where arm 3 or the triangle cannot close.

    Parameters
    ----------
    controlled : (n, 5)
        x, y, z, rx, rz; x plays no role on parallel rails.
    signs : (n,)
        Working mode of arm 3: -1 for L, +1 for R, 0 at its serial singularity, where both meet.
    """
    if on_axis(machine):
        return closed_form(machine, controlled, signs)
    result = np.full(len(controlled), np.nan)
    for i in range(0, len(controlled), _BLOCK):
        block = slice(i, i + _BLOCK)
        angle, is_certain = nearest_root(machine, controlled[block], signs[block])
        left = np.flatnonzero(~is_certain)
        angle[left] = root_search(machine, controlled[block][left], signs[block][left])
        result[block] = angle
    return result
