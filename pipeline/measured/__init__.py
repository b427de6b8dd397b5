"""What a machine really does: poses estimated from measured reflectors, simulated measurements, and errors."""

from pipeline.measured.comparison import ErrorRow, MeasurementComparison, compare_measurement, error_rows
from pipeline.measured.estimate import Estimate, estimate_poses
from pipeline.measured.reading import Account, Skipped
from pipeline.measured.reflectors import Reflectors, reflector_positions
from pipeline.measured.table import Measurement, measurement_columns, parse_measurement, read_measurement
from pipeline.measured.tracker import SimulationSetting, simulate_measurement

__all__ = [
    "Account",
    "ErrorRow",
    "Estimate",
    "Measurement",
    "MeasurementComparison",
    "Reflectors",
    "SimulationSetting",
    "Skipped",
    "compare_measurement",
    "error_rows",
    "estimate_poses",
    "measurement_columns",
    "parse_measurement",
    "read_measurement",
    "reflector_positions",
    "simulate_measurement",
]
