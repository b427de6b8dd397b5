"""The proof for other machines than the configured one: within tolerances, or as a calibration leaves them possible."""
