"""All figures of a run at once."""

import io

import matplotlib as mpl
import pytest
from matplotlib import pyplot as plt

from pipeline.config import Config
from pipeline.figures import all_figures, clearance_figure
from pipeline.machine import Machine
from pipeline.refine.measure import PathSamples
from pipeline.retime.result import TrajectorySamples
from pipeline.route.result import Route


def test_figures_follow_the_results_at_hand(
    agder_config: Config,
    machine: Machine,
    route: Route,
    coarse: PathSamples,
    refined: PathSamples,
    trajectory: TrajectorySamples,
) -> None:
    """A route alone gives two figures, paths add two, a trajectory two; matplotlib is left as it was."""
    before = dict(mpl.rcParams)
    assert list(all_figures(agder_config, machine, route)) == ["route", "machine"]
    assert list(all_figures(agder_config, machine, route, coarse)) == ["route", "machine"]
    figures = all_figures(agder_config, machine, route, coarse, refined, trajectory)
    assert list(figures) == ["route", "machine", "kappa", "clearance", "pose", "trajectory"]
    assert dict(mpl.rcParams) == before
    assert plt.get_fignums() == []


@pytest.mark.parametrize(("kind", "magic"), [("png", b"\x89PNG"), ("pdf", b"%PDF")])
def test_figures_can_be_saved(
    agder_config: Config, machine: Machine, coarse: PathSamples, refined: PathSamples, kind: str, magic: bytes
) -> None:
    """They save without a display, as pixels and as vectors."""
    file = io.BytesIO()
    clearance_figure(agder_config, machine, coarse, refined).savefig(file, format=kind)
    assert file.getvalue().startswith(magic)
