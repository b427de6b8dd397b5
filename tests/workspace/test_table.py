"""The usable workspace as rows, text and data."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.machine import MODES, Machine
from pipeline.workspace.table import (
    TABLE_HEADER,
    WorkspaceRow,
    at_two_steps,
    setting_text,
    table_cells,
    workspace_data,
    workspace_rows,
)
from pipeline.workspace.usable import WorkspaceSetting

SETTING = WorkspaceSetting(step_m=0.05)


@pytest.fixture(scope="module")
def rows(machine: Machine) -> list[WorkspaceRow]:
    """Measure the reference machine on a coarse grid and on one twice as coarse."""
    return workspace_rows(*at_two_steps(machine, SETTING))


def test_a_row_per_mode_and_the_union_last(rows: list[WorkspaceRow]) -> None:
    """Ratios are those of the volumes, and the union is once itself."""
    assert [row.mode for row in rows] == [*MODES, "union"]
    union = rows[-1]
    assert union.union_ratio == 1.0
    for row in rows:
        assert row.union_ratio == pytest.approx(union.volume_m3 / row.volume_m3)
        assert row.area_m2 <= union.area_m2


def test_the_change_is_against_twice_the_step(machine: Machine, rows: list[WorkspaceRow]) -> None:
    """The coarse volume is the one of a grid twice as coarse, and the change is in per cent of it."""
    twice, _ = at_two_steps(machine, replace(SETTING, step_m=0.1))
    assert [row.coarse_volume_m3 for row in rows] == [*twice.volumes_m3.tolist(), twice.union_m3]
    assert rows[-1].change_per_cent == pytest.approx(100.0 * (rows[-1].volume_m3 / rows[-1].coarse_volume_m3 - 1.0))


def test_nothing_has_no_ratios(machine: Machine) -> None:
    """Where kappa allows nothing, volumes are zero and ratios are dashes."""
    rows = workspace_rows(*at_two_steps(machine, WorkspaceSetting(kappa_max=1.0, step_m=0.1)))
    assert {row.union_ratio for row in rows} == {row.change_per_cent for row in rows} == {None}
    assert table_cells(rows)[0] == ("LLL", "0.0000", "0.0000", "-", "0.0000", "-")


def test_cells_fill_the_header(rows: list[WorkspaceRow]) -> None:
    """Every row has a text per heading."""
    assert {len(cells) for cells in table_cells(rows)} == {len(TABLE_HEADER)}


def test_the_setting_is_said(machine: Machine) -> None:
    """Tilt, cap, clearances and step are in the line below the table; rails only where they are checked."""
    setting = WorkspaceSetting(kappa_max=30.0, rx_rad=np.deg2rad(-10.0), step_m=0.01)
    text = setting_text(machine, setting)
    for part in ("rx -10 deg", "rz 0 deg", "kappa at most 30", "0.03 m", "grid step 0.01 m"):
        assert part in text
    assert "links and rails" not in text
    assert "links and rails 0.05 m" in setting_text(replace(machine, link_rail_m=0.05), setting)


def test_the_data_holds_both_ratios(machine: Machine, rows: list[WorkspaceRow]) -> None:
    """The two ratios to compare with are those of the rows LLL and RRR."""
    data = workspace_data(machine, SETTING, rows)
    assert (data["union_over_lll"], data["union_over_rrr"]) == (rows[0].union_ratio, rows[7].union_ratio)
    assert data["setting"]["coarse_step_m"] == 0.1
