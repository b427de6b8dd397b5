"""The first estimate: where the tracker stands, how the machine is assembled, and whether data are what they seem."""
