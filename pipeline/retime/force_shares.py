"""What forces leave for motion: a limit less the force that holds the machine at rest is all that motion may take."""

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.retime.path_dynamics import Terms
from pipeline.retime.quantities import limits

_NO_ROOM = 1e-12
"""Part of a limit that counts as no room at all."""


def moving_shares(terms: Terms, values: dict[str, FloatArray]) -> dict[str, FloatArray]:
    """Share of what forces at rest leave of their limits that motion takes, at n places.

    With c the force at rest, F the force in motion and L its limit: |F - c| / (L - c) where F is above c, and
    |F - c| / (L + c) where it is below. One is the limit itself, and time stretched by f makes it smaller by f^2,
    however near to the limit the force at rest is.

    Parameters
    ----------
    values : mapping
        Quantities by their names, of `Terms.values` for the same terms; none of forces where there are no masses.

    Returns
    -------
    mapping
        Shares (n, subjects) by the names of the forces; infinite where rest leaves no room at all.
    """
    allowed, shares = limits(terms.machine), {}
    for name, rest in terms.resting().items():
        moving, limit = values[name] - rest, allowed[name]
        room = limit - np.sign(moving) * rest
        with np.errstate(divide="ignore", invalid="ignore"):
            shares[name] = np.where(
                moving == 0.0, 0.0, np.where(room > _NO_ROOM * limit, np.abs(moving) / room, np.inf)
            )
            shares[name][:, np.isinf(limit)] = 0.0
    return shares
