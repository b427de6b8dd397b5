"""Tuning the drives' controllers: poles of the controlled machine along a motion, and gains that are stable."""

from pipeline.simulate.tuning.poles import Linearised, Poles, SampledMachine, linearised, loop_poles, sampled_machine
from pipeline.simulate.tuning.search import Gains, Tuning, tune_drives, with_gains

__all__ = [
    "Gains",
    "Linearised",
    "Poles",
    "SampledMachine",
    "Tuning",
    "linearised",
    "loop_poles",
    "sampled_machine",
    "tune_drives",
    "with_gains",
]
