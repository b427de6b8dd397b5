"""What belongs to commands of a calibration: poses to measure next, and pictures."""
