"""A machine whose geometry is a little off, as that of every real one is."""

from dataclasses import replace

import numpy as np

from pipeline.arrays import FloatArray
from pipeline.machine.geometry import Machine


def generators(seed: int) -> tuple[np.random.Generator, np.random.Generator]:
    """Make the generators of a seed: of the geometry, so that it is the same whatever else is drawn, and of noise."""
    geometry, noise = np.random.SeedSequence(seed).spawn(2)
    return np.random.default_rng(geometry), np.random.default_rng(noise)


def perturbed(machine: Machine, std_m: float, random: np.random.Generator) -> tuple[Machine, FloatArray]:
    """Draw a machine with a perturbed geometry, and zeros (2,) of its telescopes, with standard deviation `std_m`."""

    def off(values: FloatArray) -> FloatArray:
        return values + random.normal(0.0, std_m, values.shape)

    real = replace(
        machine,
        rails_m=off(machine.rails_m),
        platform_points_m=off(machine.platform_points_m),
        cart_offsets_m=off(machine.cart_offsets_m),
        lengths_m=off(machine.lengths_m),
    )
    return real, off(np.zeros(2))
