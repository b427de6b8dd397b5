"""Measured static poses: from files, at random, and simulated."""
