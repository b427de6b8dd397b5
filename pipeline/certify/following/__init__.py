"""How far actuators may be off the path: kinds of errors, the search for the largest of each, and their profile."""

from pipeline.certify.following.weights import BY_VELOCITY, COMMON, following_weights

__all__ = ["BY_VELOCITY", "COMMON", "following_weights"]
