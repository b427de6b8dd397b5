"""Loads, use of limits and the phase plane: what is drawn is what the trajectory does."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy.interpolate import make_interp_spline

from pipeline.figures import has_loads, loads_figure, phase_figure, usage_figure
from pipeline.machine import Machine
from pipeline.machine.geometry import ACTUATORS
from pipeline.refine.measure import PathSamples
from pipeline.refine.result import Path
from pipeline.retime import QUANTITIES, Quantity, Trajectory
from pipeline.retime.fastest import plan
from pipeline.retime.jerk.solve import limit_jerk
from pipeline.retime.path_dynamics import evaluate_dynamics, grid, tabulate_dynamics
from pipeline.retime.quantities import evaluate


@pytest.fixture(scope="module")
def path(machine: Machine, refined: PathSamples) -> Path:
    """The refined path as splines."""
    rows = np.arange(0, 101, 4)
    return Path(machine, make_interp_spline(refined.s[rows], refined.q_m[rows], k=5), refined.s, refined.pose)


@pytest.fixture(scope="module")
def timed(path: Path) -> Trajectory:
    """The path with limited jerk."""
    return limit_jerk(tabulate_dynamics(path, grid(501)), plan(path, 500), 80).trajectory


def test_loads_have_a_panel_for_each_kind(timed: Trajectory, assert_laid_out: Callable[[Figure], None]) -> None:
    """Jerks and forces of carts and telescopes, forces along links; as many curves as there are of each."""
    figure = loads_figure(timed)
    labels = [axes.get_ylabel().split("\n")[0] for axes in figure.axes]
    assert {axes.get_ylabel().partition("\n")[2] for axes in figure.axes[2:]} <= {
        "limit 400",
        "limit 1000",
        "limit 2000",
    }
    assert labels == [
        "cart jerk (m/s³)",
        "telescope jerk (m/s³)",
        "cart force (N)",
        "telescope force (N)",
        "force along links (N)",
    ]
    curves = [[line for line in axes.get_lines() if len(line.get_xdata()) > 2] for axes in figure.axes]
    assert [len(found) for found in curves] == [3, 2, 3, 2, 6]
    assert np.abs(curves[0][0].get_ydata()).max() <= 40.1
    assert_laid_out(figure)


def test_what_is_not_known_has_no_panel(
    timed: Trajectory, path: Path, assert_laid_out: Callable[[Figure], None]
) -> None:
    """Without masses there are jerks alone, without limited jerk forces alone, and without both there is no figure."""
    massless = replace(path, machine=replace(path.machine, masses=None))
    figure = loads_figure(replace(timed, path=massless))
    assert [axes.get_ylabel() for axes in figure.axes] == ["cart jerk (m/s³)", "telescope jerk (m/s³)"]
    assert [axes.get_xlabel() for axes in figure.axes] == ["time (s)"] * 2
    assert_laid_out(figure)
    figure = loads_figure(plan(path, 300))
    assert [axes.get_ylabel().split("\n")[0][-9:] for axes in figure.axes] == ["force (N)", "force (N)", "links (N)"]
    assert [axes.get_xlabel() for axes in figure.axes] == ["", "", "time (s)"]
    assert_laid_out(figure)
    neither = plan(massless, 300)
    assert not has_loads(neither)
    with pytest.raises(ValueError, match="no loads"):
        loads_figure(neither)


def test_every_panel_of_the_loads_has_numbers_on_its_time_axis(timed: Trajectory) -> None:
    """Panels above are narrower than the one below: its numbers do not stand for theirs."""
    figure = loads_figure(timed)
    figure.draw_without_rendering()
    for axes in figure.axes:
        assert any(label.get_visible() and label.get_text() for label in axes.get_xticklabels())


def test_usage_never_leaves_one(timed: Trajectory, assert_laid_out: Callable[[Figure], None]) -> None:
    """A panel for each kind of limit, no curve above one; some limit is always nearly used up."""
    figure = usage_figure(timed)
    curves = [line for axes in figure.axes for line in axes.get_lines() if len(line.get_xdata()) > 2]
    assert len(figure.axes) == len(curves)
    assert [line.get_label() for line in curves] == ["velocity", "acceleration", "jerk", "force", "link force"]
    used = np.array([line.get_ydata() for line in curves])
    assert used.max() <= 1.001
    assert np.mean(used.max(axis=0) > 0.9) > 0.8
    assert_laid_out(figure)


def test_another_quantity_has_a_panel(timed: Trajectory) -> None:
    """One more row of the table is one more panel, with the curve of whichever actuator uses most of the limit."""
    slope = Quantity("slope", "m/s", ACTUATORS, limit=lambda _: np.full(5, 9.0), value=lambda path, t: path.q1 * t.sd)
    panel = usage_figure(timed, (*QUANTITIES, slope)).axes[-1]
    curve = panel.get_lines()[0]
    speeds = np.abs(timed.q(curve.get_xdata(), 1)).max(axis=1)
    assert curve.get_label() == "slope"
    assert curve.get_ydata() == pytest.approx(speeds / 9.0, abs=1e-9)


def test_the_trajectory_stays_below_the_maximum_velocity_curve(
    timed: Trajectory, assert_laid_out: Callable[[Figure], None]
) -> None:
    """Path speed over s, under both curves."""
    figure = phase_figure(timed)
    cap, top, speed = figure.axes[0].get_lines()
    below = np.interp(speed.get_xdata(), top.get_xdata(), top.get_ydata())
    assert np.all(speed.get_ydata() <= below * 1.01)
    assert np.all(top.get_ydata() <= cap.get_ydata() * (1.0 + 1e-12))
    assert_laid_out(figure)


def test_limits_of_push_and_pull_are_on_their_sides(timed: Trajectory) -> None:
    """Above zero what may be pushed, below what may be pulled; a usage is of the limit on its side."""
    machine = timed.path.machine
    used = np.abs(evaluate(evaluate_dynamics(timed.path, np.linspace(0.0, 1.0, 101)), *np.zeros((3, 101)))["force"])
    most = float(used[:, :3].max())
    force = np.array([[1.1 * most] * 5, [1.3 * most] * 5])
    lopsided = replace(timed, path=replace(timed.path, machine=replace(machine, force_n=force)))
    carts = next(axes for axes in loads_figure(lopsided).axes if axes.get_ylabel().startswith("cart force"))
    lines = sorted(line.get_ydata()[0] for line in carts.get_lines() if len(line.get_xdata()) == 2)
    assert lines == pytest.approx([-1.3 * most, 1.1 * most])
