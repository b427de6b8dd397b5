"""Loads of a motion in plain floats: along the path, and over time."""
