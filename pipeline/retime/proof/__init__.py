"""The proof that a motion keeps its kinematic limits at every instant, not only where it is sampled."""
