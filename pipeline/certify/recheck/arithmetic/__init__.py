"""Intervals in plain floats for many boxes at a time: series, the closures along them, and their inclusions."""
