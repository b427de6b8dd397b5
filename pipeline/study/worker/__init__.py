"""What a worker of a study does with a run: a process of its own has it, from request to row."""
