"""Singularity-free assembly-mode reconfiguration of 5-DOF Gantry-Tau machines, from a YAML file to the controller."""
