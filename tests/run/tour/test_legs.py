"""A leg of a tour."""

from dataclasses import replace
from pathlib import Path

import pytest

from pipeline.artifacts.tour import TourFolder
from pipeline.atlas.graph import AtlasGraph
from pipeline.errors import NoSolutionError
from pipeline.progress import QUIET
from pipeline.run.stage_specs import SPECS
from pipeline.run.tour.legs import LegMaker


def test_a_search_that_ran_out_of_time_is_told(vary, graph: AtlasGraph, tmp_path: Path):
    """With the stage, and the option that gives it more."""
    hasty = replace(graph, config=vary(graph.config, {"route.time_limit_s": 1e-9}))
    with pytest.raises(NoSolutionError, match=r"route: no route was found within .*--leg-s") as caught:
        LegMaker(graph.config, hasty, TourFolder(tmp_path), 1.0, SPECS).make(0, 1, QUIET)
    assert caught.value.stage == "tour"
