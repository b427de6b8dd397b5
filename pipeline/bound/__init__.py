"""What no continuous path can do: a theorem for the machine without tilt, and floods over boxes for all others."""
