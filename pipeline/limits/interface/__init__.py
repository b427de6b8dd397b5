"""The questions asked of a limit, and the types of their answers."""
