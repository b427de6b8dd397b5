"""Dense samples of both paths."""

from typing import TYPE_CHECKING

import numpy as np

from pipeline.refine.measure import PathSamples, sample_path

if TYPE_CHECKING:
    from pipeline.run.results import Results


def sample_paths(results: "Results") -> tuple[PathSamples, PathSamples]:
    """Sample the coarse and the refined path at the same `refine.check_points` values of s."""
    s = np.linspace(0.0, 1.0, results.config.refine.check_points)
    return sample_path(results.refinement.coarse, s), sample_path(results.refinement.path, s)
