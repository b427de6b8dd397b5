"""Figures over time, and along the path in time: pose, actuators, loads, phase plane, measurements."""
