"""What bodies are: sphere-swept convex hulls of points, the frames that these move with, and pairs to keep apart."""
