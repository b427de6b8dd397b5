"""What is added to the results of a finished run."""
