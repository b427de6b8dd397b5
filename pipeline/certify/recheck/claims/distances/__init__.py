"""Distances between axes, and between the surfaces of bodies."""
