"""Limits of motion by control coefficients: they hold at every instant, not only where a program looks.

With t = T tau, the k-th derivative of a B-spline q(tau) is a B-spline of lower degree divided by T^k, and lies in the
convex hull of its coefficients: what these keep, it keeps everywhere.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline
from scipy.sparse import csr_array, diags_array

from pipeline.arrays import FloatArray
from pipeline.machine.geometry import Machine


@dataclass(frozen=True, eq=False)
class RateLimit:
    """A limit of the derivative of a given order of q by time, (5,); infinite where there is none."""

    name: str
    order: int
    largest: FloatArray


def rate_limits(machine: Machine) -> tuple[RateLimit, ...]:
    """List the limits of velocity, acceleration and jerk; an actuator that must not move at all has no velocity limit.

    It is kept from moving by its coefficients, which are all the same.
    """
    velocity = np.where(machine.velocity_mps > 0.0, machine.velocity_mps, np.inf)
    return (
        RateLimit("velocity", 1, velocity),
        RateLimit("acceleration", 2, machine.acceleration_mps2),
        RateLimit("jerk", 3, machine.jerk_mps3),
    )


def derivative_matrix(knots: FloatArray, degree: int, order: int) -> csr_array:
    """Map the coefficients of a spline (n,) to those of its derivative. Shape (n - order, n).

    c'_i = degree (c_i+1 - c_i) / (t_i+degree+1 - t_i+1), once per order (de Boor, 1978).
    """
    count = len(knots) - degree - 1
    matrix = csr_array(diags_array(np.ones(count)))
    for _ in range(order):
        factor = degree / (knots[degree + 1 : -1] - knots[1 : -degree - 1])
        matrix = csr_array(diags_array(factor) @ (matrix[1:] - matrix[:-1]))
        knots, degree = knots[1:-1], degree - 1
    return matrix


def hull_fractions(machine: Machine, spline: BSpline, motion_s: float) -> dict[str, FloatArray]:
    """Bound the fraction of every limit of motion that q(t / T) uses at any instant. (5,) by name."""
    found = {}
    for limit in rate_limits(machine):
        rates = derivative_matrix(spline.t, spline.k, limit.order) @ spline.c / motion_s**limit.order
        found[limit.name] = np.abs(rates).max(axis=0) / limit.largest
    return found


def least_motion_s(machine: Machine, spline: BSpline) -> float:
    """Compute the shortest T for which the control coefficients keep all limits of motion."""
    fractions = hull_fractions(machine, spline, 1.0)
    return float(max(fractions[limit.name].max() ** (1.0 / limit.order) for limit in rate_limits(machine)))
