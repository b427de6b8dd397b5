"""What commands share that speak of the motion of a run as a machine drives it."""
