"""The proven errors of following over s, as steps: within the limits, and on the branch alone."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.certify.result import ProvenChain


@dataclass(frozen=True, eq=False)
class FollowingProfile:
    """By how much all actuators may be off over s, two different claims.

    Attributes
    ----------
    s : (n + 1,)
        Where one of the profiles changes, and both ends.
    within_limits_m, on_branch_m : (n,)
        Errors between neighbouring s for which the limits of kappa, distances and joints are kept, and for which the
        motion merely stays regular and on its branch; NaN where that was not proven.
    stops : tuple of (str, float)
        What stopped the searches of the same errors for all s, and where: marked in figures.
    """

    s: FloatArray
    within_limits_m: FloatArray
    on_branch_m: FloatArray
    stops: tuple[tuple[str, float], ...] = ()


def following_profile(chains: Sequence[ProvenChain]) -> FollowingProfile | None:
    """Join the profiles among some chains; None if there are none."""
    found = {chain.within_limits: chain for chain in chains if chain.profile_m is not None}
    if not found:
        return None
    ends = [_changes(chain) for chain in found.values()]
    s = np.unique(np.concatenate(ends))
    middles = (s[:-1] + s[1:]) / 2.0
    unknown = np.full(len(middles), np.nan)
    within, branch = (_at(found[kept], middles) if kept in found else unknown for kept in (True, False))
    return FollowingProfile(s, within, branch)


def at_ends(steps_m: FloatArray) -> FloatArray:
    """Give the smaller of both neighbours of every s, (n + 1,): lines between these are below the steps (n,)."""
    return np.asarray(np.minimum(np.append(steps_m, np.inf), np.insert(steps_m, 0, np.inf)), dtype=float)


def _changes(chain: ProvenChain) -> FloatArray:
    profile = np.array(chain.profile_m)
    inner = [chain.boxes[k].last for k in np.flatnonzero(np.diff(profile))]
    return np.array([chain.boxes[0].first, *inner, chain.boxes[-1].last])


def _at(chain: ProvenChain, s: FloatArray) -> FloatArray:
    lasts = np.array([box.last for box in chain.boxes])
    return np.asarray(np.array(chain.profile_m)[np.searchsorted(lasts, s)], dtype=float)
