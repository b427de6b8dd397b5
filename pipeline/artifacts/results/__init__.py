"""The result of each stage as files: a module per stage writes it, and loads it back exactly."""
