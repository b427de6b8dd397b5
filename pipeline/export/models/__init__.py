"""The machine as a file for simulators: bodies, joints, loops and drives."""
