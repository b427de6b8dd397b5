"""Runs whose path is not refined from a route, but corrected from that of another run: `corrected_specs`."""
