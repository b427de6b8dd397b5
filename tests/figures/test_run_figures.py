"""All figures of a run, by the results there are."""

import io
from dataclasses import fields, replace

import matplotlib as mpl
import pytest
from matplotlib import pyplot as plt
from matplotlib.figure import Figure

from pipeline.config import Config
from pipeline.figures import FIGURES, RunData, RunFigure, all_figures, clearance_figure
from pipeline.figures.style import new_figure
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
    data = RunData(agder_config, machine, route)
    assert list(all_figures(data)) == ["route", "machine"]
    assert list(all_figures(replace(data, coarse=coarse))) == ["route", "machine"]
    figures = all_figures(replace(data, coarse=coarse, refined=refined, trajectory_samples=trajectory))
    assert list(figures) == ["route", "machine", "kappa", "clearance", "pose", "trajectory"]
    assert dict(mpl.rcParams) == before
    assert plt.get_fignums() == []


def test_a_row_is_all_a_new_figure_takes(agder_config: Config, machine: Machine, route: Route) -> None:
    """It is drawn from what it needs and uses, when that is there and the figure applies."""
    given: list[tuple[object, ...]] = []

    def draw(*results: object) -> Figure:
        given.append(results)
        return new_figure(1.0)

    data = RunData(agder_config, machine, route)
    rows = (
        RunFigure("new", draw, ("machine",), uses=("coarse",)),
        RunFigure("missing", draw, ("machine", "refined")),
        RunFigure("empty", draw, ("route",), applies=lambda route: len(route) == 0),
    )
    assert list(all_figures(data, rows)) == ["new"]
    assert given == [(machine, None)]


def test_every_row_names_results_of_a_run() -> None:
    """What figures need and use are fields of the results, and no two figures have the same file."""
    known = {field.name for field in fields(RunData)}
    assert {name for row in FIGURES for name in (*row.needs, *row.uses)} <= known
    assert len({row.name for row in FIGURES}) == len(FIGURES)


@pytest.mark.parametrize(("kind", "magic"), [("png", b"\x89PNG"), ("pdf", b"%PDF")])
def test_figures_can_be_saved(
    agder_config: Config, machine: Machine, coarse: PathSamples, refined: PathSamples, kind: str, magic: bytes
) -> None:
    """They save without a display, as pixels and as vectors."""
    file = io.BytesIO()
    clearance_figure(agder_config, machine, coarse, refined).savefig(file, format=kind)
    assert file.getvalue().startswith(magic)
