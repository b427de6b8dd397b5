"""The search for the best route: states, objective, proven optimum, and its placement along X."""
