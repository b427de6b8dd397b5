"""Bounds over a box of what gravity does: forces that hold the machine, and the stiffness that it gives the axes."""
