"""Studies: a configuration run many times with keys that vary, on one machine or many, with nothing lost."""
