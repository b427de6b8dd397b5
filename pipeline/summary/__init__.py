"""What `summary.json` says of a run: a section for each stage, and the same in a few words."""
