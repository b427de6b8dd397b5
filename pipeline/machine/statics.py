"""The statics matrix H, its condition number and the sign of its determinant: how near Type-II singularities are."""

import numpy as np

from pipeline.arguments import require_shape
from pipeline.arrays import FloatArray
from pipeline.errors import ArgumentError
from pipeline.machine.geometry import Machine, cross, dot, link_vectors, platform_arms


def statics_matrix(machine: Machine, pose: FloatArray, carts_m: FloatArray) -> FloatArray:
    """H of (1)-(2) for poses (..., 6) and carts (..., 3): column l is [u_l ; A'_l x u_l / L]. Shape (..., 6, 6).

    u_l is the unit vector along link l, from cart to platform; moments are about the TCP, divided by the machine's
    characteristic length L, so that all entries are plain numbers and kappa does not depend on the size of a machine.
    Where a pose holds NaN, so does H.

    Raises
    ------
    ArgumentError
        If poses or carts have other shapes.
    """
    require_shape("pose", pose, ("...", 6))
    require_shape("carts_m", carts_m, ("...", 3))
    vectors = link_vectors(machine, pose, carts_m)
    u = vectors / np.sqrt(dot(vectors, vectors))[..., None]
    moments = cross(platform_arms(machine, pose), u) / machine.characteristic_length_m
    columns = np.concatenate([u, moments], axis=-1)
    return np.swapaxes(columns, -1, -2)


def moment_unit(machine: Machine) -> str:
    """Say what moments are measured in: "moments in m", or the machine's characteristic length."""
    length_m = machine.characteristic_length_m
    return "moments in m" if length_m == 1.0 else f"moments per {length_m:g} m"


def condition_number(H: FloatArray) -> FloatArray:
    """Compute kappa = cond_2(H) of matrices (..., 6, 6), infinite where H is singular. Shape (...).

    Raises
    ------
    ArgumentError
        If H has another shape, or holds NaN or infinite values.
    """
    require_shape("H", H, ("...", 6, 6))
    try:
        singular_values = np.linalg.svd(H, compute_uv=False)
    except np.linalg.LinAlgError:
        raise ArgumentError("H: expected finite numbers") from None
    with np.errstate(divide="ignore"):
        kappa: FloatArray = singular_values[..., 0] / singular_values[..., -1]
    return kappa


def det_sign(H: FloatArray) -> FloatArray:
    """Sign of det H of matrices (..., 6, 6): it never changes along a path free of Type-II singularities. Shape (...).

    Raises
    ------
    ArgumentError
        If H has another shape.
    """
    require_shape("H", H, ("...", 6, 6))
    sign: FloatArray = np.sign(np.linalg.det(H))
    return sign
