"""Which results are up to date: what each stage depends on, as one hash."""
