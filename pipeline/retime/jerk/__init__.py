"""The shortest motion with bounded jerk: a nonlinear program over a time law of quartic pieces."""
