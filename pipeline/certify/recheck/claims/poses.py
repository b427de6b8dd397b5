"""The poses that are computed along the path are those that are proven.

Newton's method starts from known poses of the path, of which the proof knows nothing: from others it would end on
another branch. This is a check at samples, the only one of the check that proves nothing between them.
"""

import numpy as np

from pipeline.arrays import BoolArray, FloatArray
from pipeline.certify.recheck.claims.claim import Claim
from pipeline.certify.result import ProvenChain
from pipeline.errors import ForwardKinematicsError
from pipeline.refine.result import Path

POSES = "poses computed along the path are the proven ones"
_ROUNDING = 1e-8
"""Metres and radians by which Newton's method may end beside the proven pose."""


def pose_claim(path: Path, chain: ProvenChain) -> Claim:
    """Verify that the poses at all known ones, and where boxes meet, lie within the boxes there."""
    ends = np.array([chain.boxes[0].first, *(box.last for box in chain.boxes)])
    s = np.unique(np.concatenate([ends, path.node_s[(path.node_s >= 0.0) & (path.node_s <= 1.0)]]))
    try:
        pose = path.pose(s)
    except ForwardKinematicsError as error:
        return Claim(POSES, verified=False, found=f"there is none at s = {s[error.index]:.6f}")
    within = _within(chain, ends, s, pose)
    found = f"{int(within.sum())} of {len(s)}"
    return Claim(POSES, bool(within.all()), found if within.all() else f"{found}; not at s = {s[~within][0]:.6f}")


def _within(chain: ProvenChain, ends: FloatArray, s: FloatArray, pose: FloatArray) -> BoolArray:
    """Return which poses (n, 6) at s (n,) lie within the box that holds s, shape (n,)."""
    of = np.clip(np.searchsorted(ends, s, side="right") - 1, 0, len(chain.boxes) - 1)
    cubics, radii = (np.array([getattr(box, name) for box in chain.boxes])[of] for name in ("pose", "radius"))
    t = s - (ends[of] + ends[of + 1]) / 2.0
    centre = np.einsum("nk,nki->ni", np.vander(t, cubics.shape[1], increasing=True), cubics)
    return np.asarray((np.abs(pose - centre) <= radii + _ROUNDING).all(axis=1), dtype=bool)
