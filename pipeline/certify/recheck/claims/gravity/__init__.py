"""What gravity asks of the drives: the forces that hold the machine, and the stiffness that they give."""
