"""How bodies would be in the way of a motion that was planned without them, in words."""

from collections.abc import Collection

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.limits.bodies.surface_distance import apart_words
from pipeline.machine.bodies.distances import body_distances
from pipeline.machine.bodies.placement import Frames
from pipeline.machine.clearance import common_perpendicular
from pipeline.machine.samples import PoseSamples
from pipeline.machine.shapes.model import Bodies, FrameKind, SweptHull

_SHOWN = 3
"""Pairs that are named, the worst ones."""
_NEAR_M = 0.25
"""Axes farther apart do not pass through each other between two samples."""
_AXES = "xyz"


def obstruction(bodies: Bodies, names: Collection[str], samples: PoseSamples) -> str:
    """Say which pairs of the bodies of some names come too close at n poses along a motion, the worst first.

    Of a link that passes right through a capsule it says from which side to which, and how far from its end: there it
    has to be passed round. Empty if no pair comes too close.
    """
    hulls = bodies.hulls
    own = np.array([{hulls[i].name, hulls[j].name} & set(names) != set() for i, j in bodies.pairs], dtype=bool)
    chosen = bodies.only(np.flatnonzero(own))
    if not chosen.pairs:
        return ""
    least = body_distances(chosen, samples, chosen.clearance_m).min(axis=0)
    order = [k for k in np.argsort(least, kind="stable").tolist() if least[k] < chosen.clearance_m]
    frames = Frames.of(samples.machine, samples.pose, samples.carts_m)
    through, close, passed = list[str](), list[str](), dict[str, None]()
    for k in order:
        first, second = (chosen.hulls[number] for number in chosen.pairs[k])
        body, other = (first, second) if first.name in names else (second, first)
        if words := _passing(frames, body, other):
            through.append(f"{other.name} passes right through {body.name}, {words}")
            passed[body.name] = None
        else:
            # Hulls without a radius that overlap are no distance apart.
            close.append(
                apart_words(chosen.names[k], float(least[k])) if least[k] else f"{chosen.names[k]} overlapping"
            )
    found = through[:_SHOWN] + close[: max(_SHOWN - len(through), 0)]
    if not found:
        return ""
    more = f"; and {len(order) - len(found)} more pairs too close" if len(order) > len(found) else ""
    return f"{'; '.join(found)}{more}{_round_ends(list(passed))}"


def _round_ends(names: list[str]) -> str:
    """Say what has to be done about capsules that links pass through."""
    if not names:
        return ""
    have, them = ("have", "them") if len(names) > 1 else ("has", "it")
    return f"; {' and '.join(names)} {have} to be passed round an end: make {them} shorter there, or move {them}"


def _passing(frames: Frames, body: SweptHull, other: SweptHull) -> str:
    """Say from which side to which the axis of a link passes through that of a body, and where; else nothing."""
    if other.kind != FrameKind.LINK or body.endless or len(body.points_m) != 2:
        return ""
    (p, u), (q, v) = (
        (points[0].T, (points[1] - points[0]).T) for points in (frames.points(other), frames.points(body))
    )
    signed, s, t = common_perpendicular(p, u, q, v)
    with np.errstate(invalid="ignore"):
        inside = (np.abs(s - 0.5) <= 0.5) & (np.abs(t - 0.5) <= 0.5) & (np.abs(signed) <= _NEAR_M)
        flips = np.flatnonzero(inside[1:] & inside[:-1] & (signed[1:] * signed[:-1] < 0.0))
    if len(flips) == 0:
        return ""
    at = int(flips[0])
    sides = [_side(frames, body, (p + s[:, None] * u - q - t[:, None] * v)[row], row) for row in (at, at + 1)]
    along = float(t[at])
    end = body.points_m[0 if along <= 0.5 else 1]
    far = min(along, 1.0 - along) * float(np.linalg.norm(v[at]))
    axes = "the platform" if body.kind == FrameKind.PLATFORM else "the rails"
    place = "" if body.kind == FrameKind.LINK else f" at ({', '.join(f'{value:g}' for value in end.tolist())})"
    return f"from its {sides[0]} to its {sides[1]} side (axes of {axes}), {far:.2f} m from its end{place}"


def _side(frames: Frames, body: SweptHull, away: FloatArray, row: int) -> str:
    """Name the axis that points from a body to what is `away` (3,) from it, as nearly as one does."""
    local = frames.rotation[..., row].T @ away if body.kind == FrameKind.PLATFORM else away
    axis = int(np.abs(local).argmax())
    return f"{'+' if local[axis] > 0.0 else '-'}{_AXES[axis]}"
