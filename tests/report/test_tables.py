"""Tables of a report from parts of the summary."""

from pipeline.report.tables import rows_table


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
