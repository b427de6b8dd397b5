"""Moves between regions: candidates by the paper's rules, followed continuously between their ends."""
