"""Formats of motion controllers: PLCs, LinuxCNC, ROS 2."""
