"""Figures of the YZ plane: maps of kappa, regions, routes, reach, and the usable workspace."""
