"""Maps of kappa over the YZ plane."""

import numpy as np
import pytest

from pipeline.figures.maps.kappa_map import KappaMap, kappa_map
from pipeline.machine import MODES, Machine, inverse_kinematics, statics_matrix

Y_M = np.linspace(-0.4, 1.0, 41)
Z_M = np.linspace(0.4, 1.4, 31)


@pytest.mark.parametrize(("tilt_deg", "mode"), [((0.0, 0.0), "LLL"), ((-10.0, -30.0), "LRR"), ((20.0, 10.0), "RLR")])
def test_map_agrees_with_single_poses(machine: Machine, tilt_deg: tuple[float, float], mode: str) -> None:
    """Every value is what one pose at that y and z gives on its own, at any x; out of reach there is none."""
    rx, rz = np.deg2rad(tilt_deg)
    a_map = kappa_map(machine, Y_M, Z_M, (rx, rz), MODES.index(mode))
    assert a_map.kappa.shape == a_map.det.shape == (len(Z_M), len(Y_M))
    for row in range(0, len(Z_M), 6):
        for column in range(0, len(Y_M), 8):
            controlled = np.array([[0.7, Y_M[column], Z_M[row], rx, rz]])
            solution = inverse_kinematics(machine, controlled, np.array([MODES.index(mode)]))
            kappa, det = a_map.kappa[row, column], a_map.det[row, column]
            assert np.isfinite(kappa) == np.isfinite(det) == solution.reachable[0]
            if solution.reachable[0]:
                H = statics_matrix(machine, solution.pose, solution.q_m[:, :3])[0]
                assert kappa == pytest.approx(np.linalg.cond(H), rel=1e-9)
                assert det == pytest.approx(np.linalg.det(H), rel=1e-9)


def test_tilt_brings_singularities(machine: Machine) -> None:
    """Mode LRR at rz -30 degrees has det H = 0 inside its reach, LLL without tilt has not."""
    tilted = kappa_map(machine, Y_M, Z_M, (np.deg2rad(-10.0), np.deg2rad(-30.0)), MODES.index("LRR"))
    assert tilted.has_singularities
    assert not kappa_map(machine, Y_M, Z_M, (0.0, 0.0), MODES.index("LLL")).has_singularities


def synthetic(det: list[list[float]]) -> KappaMap:
    """Make a map with a given det H."""
    values = np.array(det)
    return KappaMap(np.arange(float(values.shape[1])), np.arange(float(values.shape[0])), np.ones_like(values), values)


def test_only_sign_changes_inside_the_reach_count() -> None:
    """A sign that changes across a gap, or over a cell not wholly in reach, is not a singularity."""
    nan = np.nan
    assert synthetic([[1.0, -1.0], [1.0, -1.0]]).has_singularities
    assert synthetic([[1.0, 1.0], [1.0, -1.0]]).has_singularities
    assert not synthetic([[1.0, 2.0], [1.0, 2.0]]).has_singularities
    assert not synthetic([[1.0, nan, -1.0], [1.0, nan, -1.0]]).has_singularities
    assert not synthetic([[1.0, -1.0], [nan, -1.0]]).has_singularities
    assert not synthetic([[nan, nan], [nan, nan]]).has_singularities
