"""Tables of a report from parts of the summary."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from pipeline.certify import Ranges
from pipeline.config import Config
from pipeline.machine import Machine
from pipeline.report.tables import bounds_table, rows_table
from tests.certify.paths import bounds_of


def test_what_a_controller_makes_of_rows_is_a_line_per_interpolation() -> None:
    """The worst actuator of each figure, in units people read; a dash for what an interpolation does not have."""
    section = {
        "linear": {
            "deviation_m": [2e-6, 3e-6],
            "usage": {"velocity": [0.5, 0.9]},
            "jump": {"velocity_mps": [0.1, 0.02]},
        },
        "cubic": {
            "deviation_m": [1e-9, 2e-9],
            "usage": {"velocity": [0.5, 0.9], "acceleration": [1.01, 0.4], "jerk": [0.3, 0.2]},
            "jump": {"acceleration_mps2": [0.03, 0.01]},
        },
    }
    table = rows_table(section)
    assert table.rows == (
        ("linear", "3.000", "0.9000", "−", "−", "0.1 m/s"),
        ("cubic", "0.002", "0.9000", "1.0100", "0.3000", "0.03 m/s²"),
    )
    assert len(table.header) == 6
    assert "--safe" in table.note


def test_boxes_to_avoid_are_a_line_each(quick_config: Config, machine: Machine, vary: Callable) -> None:
    """With what is proven of each, and units after a space."""
    config = vary(quick_config, {"task.avoid": [{"z_m": [0.0, 0.1]}, {"rx_deg": [20.0, 25.0]}]})
    boxes = Ranges(("task.avoid[0]", "task.avoid[1]"), np.array([[0.2, np.inf], [-1.1e-5, np.inf]]))
    bounds = bounds_of()
    rows = bounds_table(config, machine, replace(bounds, ranges={**bounds.ranges, "avoided_by": boxes})).rows
    assert ("out of task.avoid[0]", "at least 0.20000 m or rad", "at least 0 m or rad") in rows
    assert ("out of task.avoid[1]", "at least −0.00001 m or rad", "at least 0 m or rad") in rows
