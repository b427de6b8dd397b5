"""Where a calibration starts: the tracker's frame, and how the machine is assembled at every pose.

Data that are not what they are taken for are recognised here: other units, reflectors in another order, a tracker with
a left-handed frame.
"""

from collections.abc import Iterator
from itertools import permutations, product

import numpy as np

from pipeline.arrays import BoolArray, FloatArray, IntArray
from pipeline.calibrate.data.poses import StaticPoses
from pipeline.calibrate.estimate.assemblies import assemblies
from pipeline.calibrate.estimate.clocks import planned_poses
from pipeline.calibrate.estimate.frame import Frame, fit_frame_robustly
from pipeline.calibrate.model.forward import close, positions
from pipeline.calibrate.model.model import Model
from pipeline.config import Config
from pipeline.errors import UsageError
from pipeline.measured.plausibility import LENGTHS

_ROUNDS = 10
_ANCHORS = 6
"""Rows from whose candidates those of the others are chosen first."""
_LIKE = 2.0
"""Largest ratio between a spread in another unit and the factor of that unit."""
_BEYOND = 0.05
"""How far encoders may be beyond travels and strokes, as a part of these."""
_ROUNDING_M = 1e-12
_LEAST_WIDTH_M = 0.01
_CLEARLY = 3.0
"""How much better data have to fit as something else to be that."""
_MOTIONS = "; that the motion is the one driven (--run, --speed, --period, --back)"
_FARTHEST_M = 0.02
"""How far points may be off the configured machine in the median: farther off it is another one."""


def start(config: Config, model: Model, poses: StaticPoses) -> tuple[Model, FloatArray]:
    """Give the configured machine in a first estimate of the tracker's frame, and poses (n, 6) for every row.

    Raises
    ------
    UsageError
        When encoders are out of their ranges, the machine cannot be assembled somewhere, or what was seen is in another
        unit, of other reflectors, of a left-handed tracker, or of another machine: each is told as what it is.
    """
    _require_ranges(config, model, poses)
    found = _assemblies(config, model, poses)
    for row, some in enumerate(found):
        if len(some) == 0:
            raise UsageError(
                f"{poses.place(row)}: with these encoder positions the configured machine cannot be assembled on the "
                "side of its Type-II singularities where task.start is.\n"
                "  What to change: check the order of q1_m to q5_m, and task.start; leave the row out if it is wrong."
            )
    candidates = _Candidates(model, found, poses)
    _require_units(poses, candidates)
    frame, choice = candidates.fit()
    if frame.median_m > _FARTHEST_M:
        _require_reflectors(model, poses)
        _require_order(poses, candidates, frame)
        raise UsageError(
            f"the reflectors are {1e3 * frame.median_m:.0f} mm off the configured machine in the median, "
            "however the tracker stands.\n  What to change: check that file and configuration are of one machine, and "
            f"the places of the reflectors (--reflector-1 ...){_MOTIONS if poses.motions else ''}."
        )
    _require_width(candidates.points_of(choice)[poses.is_seen])
    guess = np.array([some[index] for some, index in zip(found, choice, strict=True)])
    return model.with_frame(frame.rotation, frame.translation_m), guess


def _assemblies(config: Config, model: Model, poses: StaticPoses) -> list[FloatArray]:
    """Find poses (k, 6) that the machine may have at every row: along motions those that were planned."""
    moving, q = poses.is_moving, poses.encoders(model.clocks_s)
    still = iter(assemblies(config, model.actuators(q[~moving])) if not moving.all() else [])
    planned = iter(list(planned_poses(model, poses)[:, None]) if moving.any() else [])
    return [next(planned) if moves else next(still) for moves in moving.tolist()]


class _Candidates:
    """Where reflectors would be seen at every pose the machine may have at every row."""

    def __init__(self, model: Model, found: list[FloatArray], poses: StaticPoses) -> None:
        self.counts = np.array([len(some) for some in found])
        self.first = np.cumsum(self.counts) - self.counts
        self.rows = np.repeat(np.arange(len(found)), self.counts)
        pose = np.concatenate(found)
        self.points_m = positions(model, close(model, poses.encoders(model.clocks_s)[self.rows], pose))
        self.upright = self._least(np.abs(pose[:, [3, 5]]).max(axis=1))
        self.seen_m = poses.seen_m

    def fit(self, order: tuple[int, ...] | None = None, mirrored: bool = False) -> tuple[Frame, IntArray]:
        """Fit the frame, and choose the candidate of every row that it fits best, with reflectors in another order."""
        seen = self.seen_m if order is None else self.seen_m[:, order]
        best: tuple[Frame, IntArray] | None = None
        for choice in self._first_choices(seen):
            frame, choice = self._settled(choice, seen, mirrored)
            if best is None or frame.median_m < best[0].median_m:
                best = frame, choice
            if frame.median_m < _FARTHEST_M:
                break
        assert best is not None
        return best

    def points_of(self, choice: IntArray) -> FloatArray:
        """Where reflectors would be seen at the chosen candidates. Shape (n, reflectors, 3)."""
        return np.asarray(self.points_m[self.first + choice])

    def _settled(self, choice: IntArray, seen: FloatArray, mirrored: bool) -> tuple[Frame, IntArray]:
        """Fit and choose by turns."""
        known = np.isfinite(seen).all(axis=2)
        for _ in range(_ROUNDS):
            frame = fit_frame_robustly(self.points_of(choice)[known], seen[known], mirrored)
            miss = self.points_m @ frame.rotation.T + frame.translation_m - seen[self.rows]
            before, choice = choice, self._least(np.nanmax(np.linalg.norm(miss, axis=2), axis=1))
            if (choice == before).all():
                break
        return frame, choice

    def _first_choices(self, seen: FloatArray) -> Iterator[IntArray]:
        """Choose candidates that are as far from one of a row as reflectors were seen to be; upright ones, first."""
        yield self.upright
        for row in np.unique(np.linspace(0, len(seen) - 1, _ANCHORS).astype(int)):
            apart = np.linalg.norm(seen - seen[row], axis=2)
            for point in self.points_m[self.rows == row]:
                off = np.linalg.norm(self.points_m - point, axis=2) - apart[self.rows]
                yield self._least(np.nansum(off**2, axis=1))

    def _least(self, value: FloatArray) -> IntArray:
        """Choose the candidate of every row with the least value (candidates,). Shape (n,)."""
        places = zip(self.first, self.counts, strict=True)
        return np.array([int(np.argmin(value[first : first + count])) for first, count in places])


def _require_ranges(config: Config, model: Model, poses: StaticPoses) -> None:
    """Refuse encoder positions that are not within travels and strokes."""
    ranges = [rail.travel_m for rail in config.machine.rails]
    limits = np.array([*ranges, config.machine.links.l2b.stroke_m, config.machine.links.l3b.stroke_m])
    slack = _BEYOND * np.ptp(limits, axis=1)

    def is_beyond(q_m: FloatArray) -> BoolArray:
        q = model.actuators(q_m)
        return np.asarray((q < limits[:, 0] - slack) | (q > limits[:, 1] + slack))

    if not (beyond := is_beyond(poses.q_m)).any():
        return
    for unit, factor in LENGTHS.items():
        if not is_beyond(poses.q_m / factor).any():
            raise UsageError(f"q1_m to q5_m look like {unit}.\n  What to change: divide them by {factor:.10g}.")
    row, column = (int(index) for index in np.argwhere(beyond)[0])
    raise UsageError(
        f"{poses.place(row)}: q{column + 1}_m is {poses.q_m[row, column]:g}, beyond its range "
        f"{limits[column].tolist()} in the configuration.\n"
        "  What to change: check the order of the columns, zero_m of machine.actuators, and the range."
    )


def _require_units(poses: StaticPoses, candidates: _Candidates) -> None:
    """Refuse positions in another unit: they are spread as many times as wide as those of the machine."""

    def spread(points: FloatArray) -> float:
        return float(np.linalg.norm(points - np.median(points, axis=0), axis=1).mean())

    seen = poses.is_seen
    expected = candidates.points_of(candidates.upright)[seen]
    ratio = max(spread(poses.seen_m[seen]), _ROUNDING_M) / max(spread(expected), _ROUNDING_M)
    unit, factor = min({"metres": 1.0, **LENGTHS}.items(), key=lambda one: abs(np.log(ratio / one[1])))
    if factor != 1.0 and abs(np.log(ratio / factor)) < np.log(_LIKE):
        raise UsageError(
            f"the positions of the reflectors look like {unit}: they are spread {ratio:.3g} times as wide as those "
            f"of the machine.\n  What to change: divide them by {factor:.10g}."
        )


def _require_width(points_m: FloatArray) -> None:
    """Refuse points (n, 3) that are nearly on a line: about it a frame may turn."""
    across = np.linalg.svd(points_m - points_m.mean(axis=0), compute_uv=False)[1] / np.sqrt(len(points_m))
    if across < _LEAST_WIDTH_M:
        raise UsageError(
            f"all points are within {1e3 * across:.1f} mm (rms) of a line, which does not tell where the tracker "
            "stands.\n  What to change: measure poses all over the workspace."
        )


def _require_reflectors(model: Model, poses: StaticPoses) -> None:
    """Refuse reflectors whose distances are not those given, in whatever order they are."""
    count = len(model.reflectors_m)
    pairs = [(a, b) for a in range(count) for b in range(a)]
    given = [float(np.linalg.norm(model.reflectors_m[a] - model.reflectors_m[b])) for a, b in pairs]
    apart = [np.linalg.norm(poses.seen_m[:, a] - poses.seen_m[:, b], axis=1) for a, b in pairs]
    seen = [float(np.nanmedian(one)) for one in apart if np.isfinite(one).any()]
    if len(seen) < len(given):
        return
    off = np.abs(np.sort(seen) - np.sort(given))
    if off.max(initial=0.0) > _FARTHEST_M:
        worst = int(np.argmax(off))
        raise UsageError(
            f"two reflectors are measured {np.sort(seen)[worst]:.4f} m apart, but {np.sort(given)[worst]:.4f} m as "
            "they are given.\n  What to change: give the places of the reflectors in the platform frame, in metres."
        )


def _require_order(poses: StaticPoses, candidates: _Candidates, frame: Frame) -> None:
    """Refuse reflectors in another order and left-handed frames, where these fit much better."""
    usual = tuple(range(poses.seen_m.shape[1]))
    fits = {}
    for order, mirrored in product(permutations(usual), (False, True)):
        if order != usual or mirrored:
            fits[order, mirrored] = candidates.fit(order, mirrored)[0].median_m
    order, mirrored = min(fits, key=lambda one: fits[one])
    if _CLEARLY * fits[order, mirrored] >= frame.median_m:
        return
    said = []
    if order != usual:
        columns = ", ".join(f"x{index + 1}_m" for index in order)
        said.append(f"reflectors are in another order: take {columns} (and y, z) for 1, 2, ...")
    if mirrored:
        said.append("the tracker's frame is left-handed: swap two of its axes, or change the sign of one")
    raise UsageError(
        f"the measurement fits the machine to {1e3 * fits[order, mirrored]:.1f} mm in the median, instead of "
        f"{1e3 * frame.median_m:.1f} mm, if {' and '.join(part.split(':')[0] for part in said)}.\n"
        f"  What to change: {'; '.join(part.split(': ')[1] for part in said)}."
    )
