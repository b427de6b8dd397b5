"""The benchmark of stage three: it runs, its figures are consistent, and alternatives keep what they claim."""

import re

import numpy as np
import pytest

from pipeline.refine.result import Path
from tests.benchmarks.alternatives import ALTERNATIVES, ruckig_stops
from tests.benchmarks.retiming import markdown, study


def test_a_small_study_has_every_figure_and_well_formed_tables(path: Path) -> None:
    """Finer grids are nearer to the bound, every bound is below every plan, no profile is faster."""
    s = np.linspace(0.0, 1.0, 6)
    found = study(path, path.q(s), grids=(100, 400), pieces=(80,))
    coarse, fine = found["grids"]
    assert 0.0 < fine["gap"] < coarse["gap"]
    assert max(row["bound_s"] for row in found["bounds"]) <= found["bound_s"] < fine["duration_s"]
    assert found["jerk"][0]["duration_s"] > fine["duration_s"] * 0.999
    names = [name for name, _ in ALTERNATIVES]
    assert [row["name"] for row in found["alternatives"]] == names
    along = [row["duration_s"] for row in found["alternatives"] if "along the path" in row["name"]]
    assert len(along) == 2
    assert min(along) > fine["duration_s"]
    found |= {"host": {"cpu": "any"}, "stage": {"seconds": 1.0, "duration_s": 6.0, "usage": 0.999}}
    page = markdown(found)
    tables = re.findall(r"(?:^\|.*\|\n)+", page, flags=re.MULTILINE)
    assert len(tables) == 4
    for table in tables:
        assert len({line.count("|") for line in table.splitlines()}) == 1


def test_ruckig_takes_the_closed_form_time_on_a_line(line) -> None:
    """One straight move of 0.9 m: D / v + v / a + a / j."""
    pytest.importorskip("ruckig")
    path = line(0.9)
    assert ruckig_stops(path, path.q(np.array([0.0, 1.0]))) == pytest.approx(2.1, abs=1e-6)
