"""What a descent minimises, and what its iterates have to keep."""

from collections.abc import Iterator
from dataclasses import dataclass

from scipy.sparse import csr_array

from pipeline.arrays import FloatArray
from pipeline.refine.one_way import OneWayLeg
from pipeline.refine.peak.constraints import Constraint, PathConstraints, pose_constraints
from pipeline.refine.peak.iterate import EvaluationPoints, Iterate
from pipeline.refine.peak.speed import one_way_constraint, speed_constraints


@dataclass(frozen=True)
class PeakObjective:
    """mean_weight times the mean of kappa + peak_weight times its largest value, which counts above the target only.

    What a path costs that is not smooth is added to the integral of kappa.

    Attributes
    ----------
    mean_weight, peak_weight : float
        The weights.
    target, cap : float
        The largest kappa below which lowering it further counts for nothing; the one that it must not exceed.
    length : float
        Length that means are taken over.
    smoothness : (5 n, 5 n)
        Form of that cost in the coefficients.
    """

    mean_weight: float
    peak_weight: float
    target: float
    cap: float
    length: float
    smoothness: csr_array

    def value(self, iterate: Iterate) -> float:
        """Compute the value of an iterate."""
        peak = max(float(iterate.kappa.max()), self.target)
        c = iterate.coefficients.ravel()
        cost = iterate.integral + float(c @ (self.smoothness @ c))
        return self.mean_weight * cost / self.length + self.peak_weight * peak


@dataclass(frozen=True, eq=False)
class PeakProblem:
    """What iterates have to keep, and where they are evaluated.

    Attributes
    ----------
    points : EvaluationPoints
        Where paths are evaluated.
    required : PathConstraints
        What the poses there have to keep.
    directions : (2, 5)
        Directions of the actuators at both ends, NaN where they are free.
    actuator_range_m : (5, 2)
        Bounds of the coefficients.
    one_way : tuple of OneWayLeg
        Legs of the control polygon along which an actuator must not move one way.
    """

    points: EvaluationPoints
    required: PathConstraints
    directions: FloatArray
    actuator_range_m: FloatArray
    one_way: tuple[OneWayLeg, ...] = ()

    def constraints(self, iterate: Iterate) -> Iterator[Constraint]:
        """Write everything that an iterate has to keep."""
        yield from pose_constraints(self.points, self.required, iterate)
        yield from speed_constraints(self.points, self.directions, iterate)
        if self.one_way:
            yield one_way_constraint(self.one_way, iterate)

    def excess(self, iterate: Iterate) -> float:
        """Compute how far the worst constraint is broken, in units of its slack."""
        return max(constraint.excess for constraint in self.constraints(iterate))
