"""The quality of a motion: how often its actuators reverse, and how near it is to the least time."""
