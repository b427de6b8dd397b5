"""The columns of `trajectory.csv`: the contract's names, and a row for each of them."""

import numpy as np
import pytest

from pipeline.export import TRAJECTORY_COLUMNS, TrajectoryColumn, format_csv, read_csv, sidecar, trajectory_columns
from pipeline.retime import TrajectorySamples, Usage

CONTRACT = (
    "t_s,q1_m,q2_m,q3_m,q4_m,q5_m,qd1_mps,qd2_mps,qd3_mps,qd4_mps,qd5_mps,"
    "qdd1_mps2,qdd2_mps2,qdd3_mps2,qdd4_mps2,qdd5_mps2,x_m,y_m,z_m,rx_rad,ry_rad,rz_rad,kappa"
)


@pytest.fixture
def samples(make_samples) -> TrajectorySamples:
    """Rows of a motion, every column different."""
    return make_samples(0.01)


def test_the_columns_are_those_of_the_contract(samples: TrajectorySamples) -> None:
    """Names and order are what other programs rely on, and every column holds its quantity."""
    columns = trajectory_columns(samples)
    assert ",".join(columns) == CONTRACT
    assert np.array_equal(columns["q4_m"], samples.q_m[:, 3])
    assert np.array_equal(columns["qd1_mps"], samples.qd_mps[:, 0])
    assert np.array_equal(columns["qdd5_mps2"], samples.qdd_mps2[:, 4])
    assert np.array_equal(columns["rz_rad"], samples.pose[:, 5])
    assert np.array_equal(columns["kappa"], samples.kappa)


def test_a_row_is_all_a_new_column_takes(agder_config, machine, samples: TrajectorySamples) -> None:
    """One more row is in the table and in the sidecar, at its place."""
    speed = TrajectoryColumn("v_mps", "m/s", "largest speed", lambda rows: np.abs(rows.qd_mps).max(axis=1))
    columns = (*TRAJECTORY_COLUMNS, speed)
    back = read_csv(format_csv(trajectory_columns(samples, columns)))
    assert list(back)[-2:] == ["kappa", "v_mps"]
    assert back["v_mps"] == pytest.approx(np.abs(samples.qd_mps).max(axis=1), abs=1e-12)
    described = sidecar(agder_config, machine, samples, Usage({}), columns)["columns"]
    assert described[-1] == {"name": "v_mps", "unit": "m/s", "meaning": "largest speed"}
