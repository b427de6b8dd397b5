"""A page in the browser on which the machine is jogged, a task is set and planned, and a run is played."""
