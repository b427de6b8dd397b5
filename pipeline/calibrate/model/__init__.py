"""The machine as a tracker sees it: its parameters, what is seen, and what nobody can see."""
