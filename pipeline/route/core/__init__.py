"""The core: all routes of cost at most a threshold, and what can be left out of it."""
