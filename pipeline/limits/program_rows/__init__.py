"""What limits add to the nonlinear programs of stage two, rows and unknowns: imported when a program is written."""
