"""The certificate in the summary."""

from dataclasses import replace
from typing import Any

import numpy as np

from pipeline.bound.bound import bound_all_paths
from pipeline.certify import Certificate, Ranges
from pipeline.certify.result import ProvenChain
from pipeline.config import Config
from pipeline.inclusion.uncertainty import CERTAIN
from pipeline.machine import Machine
from pipeline.route.regions.endpoints import task_endpoints
from pipeline.summary.certificate import certificate_section, certificate_words, every_path_section
from tests.certify.paths import bounds_of

CERTIFIED: dict[str, Any] = {
    "verdict": "certified",
    "boxes": 80,
    "kappa_bound": 27.345,
    "min_distance_bound_m": 0.03,
    "tolerance_m": None,
}


def test_what_no_path_can_do_is_said_where_it_is_known(quick_config: Config, machine: Machine) -> None:
    """Beside the proven largest kappa of the path stands what every path has; of other runs nothing is said."""
    assert "no path" not in certificate_words({**CERTIFIED, "least_kappa": None})
    section = every_path_section(bound_all_paths(quick_config, machine, task_endpoints(quick_config, machine), 1000))
    assert section["least_kappa_boxes"] <= 1000
    words = certificate_words({**CERTIFIED, **section})
    assert "kappa at most 27.3" in words
    assert "no path can have a largest kappa below 23.14" in words


def test_words_say_what_stopped_the_errors_of_drives() -> None:
    """For both claims, with the place; nothing where it is not known."""
    section = {**CERTIFIED, "following_m": 1.88e-3, "following_on_branch_m": 2.69e-3}
    assert "stopped by" not in certificate_words(section)
    section["following_stopped_by"] = {"common": {"limit": "links 2a and 3a", "s": 0.3007}}
    section["following_on_branch_stopped_by"] = {"common": {"limit": "regularity", "s": 0.41}}
    words = certificate_words(section)
    assert (
        "1.88 mm with kappa, distances and joints within their limits (stopped by links 2a and 3a at s = 0.301)"
        in words
    )
    assert "limits broken (stopped by regularity at s = 0.410)" in words


def test_boxes_to_avoid_are_said_where_there_are_any() -> None:
    """The least of all boxes, in words as well; of a task without boxes nothing is said."""
    given, chain = bounds_of(), ProvenChain(CERTAIN, (), ())
    boxes = Ranges(("task.avoid[0]", "task.avoid[1]"), np.array([[0.2, np.inf], [0.0125, np.inf]]))
    with_boxes = replace(given, ranges={**given.ranges, "avoided_by": boxes})
    plain, section = (
        certificate_section(Certificate("", "", 64, chain, bounds, None)) for bounds in (given, with_boxes)
    )
    assert "avoided_by_bound" not in plain
    assert "avoid" not in certificate_words(plain)
    assert section["avoided_by_bound"] == 0.0125
    assert "boxes to avoid at least 0.0125 m or rad away" in certificate_words(section)
