"""What figures read off samples: steps of the route."""

import numpy as np

from pipeline.figures.samples import corner_samples
from pipeline.machine import Machine
from pipeline.refine.measure import PathSamples
from pipeline.route.result import Route
from tests.figures.conftest import controlled_curve, make_route, make_samples


def test_corners_are_found_where_the_path_passes_them(route: Route, coarse: PathSamples) -> None:
    """The path was sampled ten times per step, so every tenth sample is a step."""
    np.testing.assert_array_equal(corner_samples(coarse, route), np.arange(0, 141, 10))


def test_places_that_are_passed_twice_are_found_in_turn(machine: Machine) -> None:
    """There and back the same way, steps on the way back are found on the way back."""
    there = np.linspace(0.0, 1.0, 31)
    steps = np.array([0.0, 0.4, 1.0, 0.4, 0.0])
    samples = make_samples(machine, controlled_curve(np.concatenate([there, there[-2::-1]])))
    np.testing.assert_array_equal(
        corner_samples(samples, make_route(machine, controlled_curve(steps))), [0, 12, 30, 48, 60]
    )
