"""A calibration as text and as plain data."""

import json
from collections.abc import Callable

import numpy as np
import pytest

from pipeline.artifacts import json_bytes
from pipeline.calibrate import Calibration, Setting, calibrate, judge, next_poses
from pipeline.calibrate.model.parameters import USUAL
from pipeline.calibrate.report import (
    ERROR_HEADER,
    FROM_DATA,
    FROM_PRIOR,
    NEXT_HEADER,
    NOT_FITTED,
    calibration_data,
    error_cells,
    next_cells,
    next_columns,
    parameter_tables,
    sources,
)
from pipeline.config import Config
from tests.calibrate.conftest import REFLECTORS_M, Seen


@pytest.fixture(scope="module")
def found(see: Callable[..., Seen], quick_config: Config) -> Calibration:
    """Calibrate with a quarter of the poses held out."""
    return calibrate(quick_config, REFLECTORS_M[:2], see(2).simulated.poses, Setting(hold_out=0.25))


def test_every_parameter_has_an_origin(found: Calibration):
    """From the data where they halve its variance, from the prior elsewhere, and not fitted where it was not."""
    told, names = sources(found), found.identification.model.parameters.names
    by_name = dict(zip(names, told, strict=True))
    assert by_name["length 1"] == FROM_DATA
    assert by_name["scale l2b"] == by_name["rail 1 y"] == FROM_PRIOR
    assert by_name["direction of rail 2 z"] == NOT_FITTED
    halved = found.identification.std**2 <= 0.5 * found.identification.problem.prior_std**2
    assert [origin == FROM_DATA for origin in told] == (halved & found.identification.problem.is_fitted).tolist()


def test_tables_have_their_columns(found: Calibration):
    """A row per fitted parameter but those of the tracker, and one for fitted and held-out poses each."""
    tables = parameter_tables(found)
    assert sum(len(table.rows) for table in tables) == 62
    for table in tables:
        assert {len(row) for row in table.rows} == {len(table.header)}
    assert [row[0] for row in error_cells(found)] == ["fitted", "held out"]
    assert {len(row) for row in error_cells(found)} == {len(ERROR_HEADER)}


def test_units_of_parameters_are_in_headers(found: Calibration):
    """Numbers below a unit are in it: a length's place in metres and its change in micrometres, scales in ppm."""
    lengths, scales = parameter_tables(found)
    assert lengths.header[1:5] == ("configured m", "change um", "deviation um", "known to um")
    assert scales.header[1:5] == ("configured", "change ppm", "deviation ppm", "known to ppm")
    names = list(found.identification.model.parameters.names)
    row = next(row for row in lengths.rows if row[0] == "length 1")
    assert row[1] == "1.090000"
    assert float(row[2]) == pytest.approx(1e6 * found.identification.theta[names.index("length 1")], abs=0.051)
    assert all(row[0].startswith("scale") and row[1] == "1.000000" for row in scales.rows)


def test_data_have_everything_as_json(found: Calibration):
    """All of it survives JSON, and says what was done."""
    data = json.loads(json_bytes(calibration_data(found, judge(found))))
    assert data["accepted"] is True
    assert data["setting"]["fit"] == list(USUAL)
    assert len(data["parameters"]) == 74
    assert np.array(data["covariance"]).shape == (74, 74)
    assert data["directions"]["gauges"] == 21
    assert len(data["directions"]["singular_values"]) == 68
    assert sum(data["modes"].values()) == data["poses"] == 30
    assert data["parameters"][-1]["prior_std"] is None


def test_poses_to_measure_are_a_table_to_be_filled(found: Calibration):
    """Reflectors are blank, encoders and poses are there, and errors fall from row to row."""
    proposed = next_poses(found, 3)
    rows = next_cells(proposed)
    assert {len(row) for row in rows} == {len(NEXT_HEADER)}
    assert [float(row[-1]) for row in rows] == sorted((float(row[-1]) for row in rows), reverse=True)
    columns = next_columns(proposed, 2)
    assert set(columns["z2_m"].tolist()) == {""}
    assert columns["mode"].tolist() == proposed.modes
    np.testing.assert_array_equal(columns["q4_m"], proposed.q_m[:, 3])
