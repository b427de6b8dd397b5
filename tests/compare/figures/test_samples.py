"""What figures read off samples: steps of the route."""

import numpy as np

from pipeline.compare.figures.samples import corner_samples
from pipeline.refine.measure import PathSamples
from pipeline.route.result import Route


def test_corners_are_found_where_the_path_passes_them(route: Route, coarse: PathSamples) -> None:
    """The path was sampled ten times per step, so every tenth sample is a step."""
    np.testing.assert_array_equal(corner_samples(coarse, route), np.arange(0, 141, 10))
