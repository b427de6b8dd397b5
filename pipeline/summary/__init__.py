"""The summary of a run: a module per stage makes its part of `summary.json` and says it in words."""
