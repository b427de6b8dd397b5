"""Pictures of the report, and their descriptions."""

import base64

import numpy as np

from pipeline.config import Config
from pipeline.limits.bodies.pairs import kept_apart, pair_distances
from pipeline.machine import Machine
from pipeline.refine.measure import sample_path
from pipeline.report.pictures import pairs_picture
from tests.run.short_results import make_refinement


def test_distances_of_bodies_are_drawn_and_described(
    bodies_config: Config, bodies_machine: Machine, quick_config: Config, machine: Machine
) -> None:
    """With the least of bodies and of obstacles; there is no such picture without bodies."""
    s = np.linspace(0.0, 1.0, 51)
    samples = sample_path(make_refinement(bodies_machine).path, s)
    found = pairs_picture(bodies_config, bodies_machine, samples)
    assert found is not None
    assert base64.b64decode(found.png).startswith(b"\x89PNG")
    for bodies, of in zip(kept_apart(bodies_config, bodies_machine), ("between bodies", "from obstacles"), strict=True):
        assert f"{1e3 * pair_distances((bodies,), samples).min():.1f} mm {of}" in found.alt
    assert pairs_picture(quick_config, machine, sample_path(make_refinement(machine).path, s)) is None
