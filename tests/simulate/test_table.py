"""A simulated motion as rows, tables, data and columns."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.certify.recheck.tube import ProvenTube
from pipeline.export.csv import format_csv, read_csv
from pipeline.machine import Machine
from pipeline.measured import parse_measurement
from pipeline.simulate import Deviations, Drives, Motion, Simulation, build_plant, simulate_motion
from pipeline.simulate.rows import determinant, drive_rows, link_rows, mode_rows, tcp_error
from pipeline.simulate.table import (
    determinant_text,
    simulation_columns,
    simulation_data,
    simulation_tables,
    trip_text,
    tube_table,
    tube_text,
)
from pipeline.simulate.tube import check_tube


@pytest.fixture(scope="module")
def simulation(agder: Machine, drives: Drives, reference: Motion) -> Simulation:
    """Simulate the reference motion with the drives that are assumed."""
    return simulate_motion(agder, build_plant(agder, Deviations()), drives, reference, standing_s=0.1)


def test_rows_sum_up_what_happened(simulation: Simulation) -> None:
    """Largest errors with their times, peaks, and shares of what is allowed."""
    for k, row in enumerate(drive_rows(simulation)):
        error = simulation.following_error_m[:, k]
        assert abs(row.following_error_m) == np.abs(error).max()
        assert error[round(row.following_error_at_s / 1e-3)] == row.following_error_m
        assert row.trip_share == pytest.approx(abs(row.following_error_m) / 0.02)
        assert row.force_share == pytest.approx(row.peak_n / simulation.drives.saturation_n[0, k])
        assert row.saturated_s == 0.0
    assert [row.link for row in link_rows(simulation)] == ["1", "2a", "2b", "3a", "3b", "3c"]
    assert all(row.largest_difference_n < 60.0 for row in link_rows(simulation))
    error = tcp_error(simulation)
    assert 0.0 < error.rms_m < error.largest_m < 0.01
    found = determinant(simulation)
    assert found.sign_kept
    assert 0.9 < found.least_ratio <= 1.0


def test_modes_are_those_of_the_plan(simulation: Simulation) -> None:
    """In their order, within 20 ms."""
    rows = mode_rows(simulation)
    assert [row.mode for row in rows] == [row.planned_mode for row in rows]
    assert rows[0].mode == "LLL"
    assert rows[-1].mode == "RRR"
    for row in rows:
        assert row.t_s == pytest.approx(row.planned_t_s, abs=0.02)


def test_modes_that_were_not_reached_are_blank(simulation: Simulation) -> None:
    """Of a motion that ends early."""
    cut = {
        name: getattr(simulation, name)[:1_000]
        for name in ("q_m", "qd_mps", "qdd_mps2", "pose", "drive_n", "friction_n", "link_n", "det_h", "planned_det_h")
    }
    short = replace(simulation, **cut, saturated=simulation.saturated[:1_000])
    assert [row.mode for row in mode_rows(short)] == ["LLL", None, None, None]
    assert simulation_tables(short)[-1].rows[-1][0] == "-"
    assert "det H keeps its sign" in determinant_text(short)


def test_tables_and_data_agree(simulation: Simulation) -> None:
    """Every table has cells for its headings; the data have what the tables show, unrounded."""
    tables, data = simulation_tables(simulation), simulation_data(simulation)
    assert all(len(row) == len(table.header) for table in tables for row in table.rows)
    assert [row["drive"] for row in data["drives"]] == [row[0] for row in tables[1].rows]
    assert float(tables[0].rows[-1][4]) == pytest.approx(1e3 * data["tcp_error"]["largest_m"], abs=1e-4)
    assert data["verdict"]["ending"] == "arrived"


def test_columns_are_a_measurement(simulation: Simulation) -> None:
    """As they are written they are read as a measurement of the motion, with the same errors."""
    columns = read_csv(format_csv(simulation_columns(simulation)))
    measurement = parse_measurement(columns, float(simulation.motion.t_s[-1]))
    assert measurement.controlled == pytest.approx(simulation.pose[:, [0, 1, 2, 3, 5]], abs=1e-11)
    assert columns["e4_m"] == pytest.approx(simulation.following_error_m[:, 3], abs=1e-11)


def test_the_tube_is_told_with_the_trip_limit_that_would_have_held_it(simulation: Simulation) -> None:
    """Inside: how much of it is used; outside: from when on, and when drives would have tripped."""
    wide, narrow = (check_tube(simulation, ProvenTube(np.full(5, eps), True)) for eps in (5e-3, 5e-4))
    assert tube_text(simulation, wide).startswith("within the proven tube of 5 mm, ")
    assert "limits of kappa, distances and joints are kept" in tube_text(simulation, wide)
    assert simulation_data(simulation, [wide])["tubes"][0]["inside"] is True
    assert simulation_data(simulation, [wide])["tubes"][0]["trip_at_s"] is None
    assert simulation_data(simulation)["tubes"] == []
    told, data = tube_text(simulation, narrow), simulation_data(simulation, [wide, narrow])["tubes"][1]
    assert told.startswith("NOT within the proven tube of 0.5 mm, from ")
    assert "following_error_trip_m at 0.5 mm" in told
    assert data["share"] > 1.0
    assert 0.0 < data["trip_at_s"] <= data["share_at_s"]
    assert f"tripped at {data['trip_at_s']:.3f} s" in told
    rows = tube_table(simulation, narrow).rows
    assert len(rows) == 5
    largest = max(float(row[4].rstrip("%")) for row in rows)
    assert largest == pytest.approx(100.0 * data["share"], abs=1.0)


def test_trip_limits_outside_a_proven_tube_are_told(simulation: Simulation) -> None:
    """By drive and by tube, as soon as a limit is above what is proven; the data say so of each tube."""
    wide, narrow = (check_tube(simulation, ProvenTube(np.full(5, eps), eps < 0.01)) for eps in (0.02, 5e-4))
    assert trip_text(simulation, []) is None
    assert trip_text(simulation, [wide]) is None
    told = trip_text(simulation, [narrow, wide])
    assert told is not None
    assert "at 20 mm, beyond 0.5 mm (no singularity is met, and limits" in told
    trips = np.array([1e-4, 1e-4, 1e-4, 1e-4, 0.03])
    of_one = replace(simulation, drives=replace(simulation.drives, trip_m=trips))
    told = trip_text(of_one, [narrow, wide])
    assert told is not None
    assert "l3b at 30 mm, beyond 0.5 mm" in told
    assert "and 20 mm (no singularity is met, but limits may be broken)" in told
    assert "c1" not in told
    tubes = simulation_data(simulation, [narrow, wide])["tubes"]
    assert [tube["trips_within"] for tube in tubes] == [False, True]
