"""The machine at every step of the route."""

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from pipeline.figures import style
from pipeline.figures.machine import MAX_MACHINES, machine_figure, postures_figure
from pipeline.figures.silhouettes import project
from pipeline.machine import MODES, Machine, inverse_kinematics
from pipeline.machine.geometry import cart_joints, link_vectors
from pipeline.route.result import Route

PER_MACHINE = 5
"""Collections of lines for each machine: rails, bars, fixed links, telescopes, cart beams, in this order of drawing."""


@pytest.fixture(scope="module")
def figure(machine: Machine, route: Route) -> Figure:
    """Draw the route's 15 machines."""
    return machine_figure(machine, route)


def lines_of(figure: Figure) -> list[LineCollection]:
    """Give all collections of lines, machine by machine."""
    return [artist for artist in figure.axes[0].collections if isinstance(artist, LineCollection)]


def test_a_machine_per_step(figure: Figure, route: Route) -> None:
    """Every step has its title with the working mode, and its own lines."""
    titles = [text.get_text() for text in figure.axes[0].texts if text.get_text()[:1].isdigit()]
    assert titles == [f"{step}  LLL" for step in range(len(route))]
    assert len(lines_of(figure)) == PER_MACHINE * len(route)


def test_links_are_projected_where_they_are(figure: Figure, machine: Machine, route: Route) -> None:
    """Each drawn link joins its cart joint to its platform joint, moved by the same offset for the whole machine."""
    for step in (0, 7):
        own = lines_of(figure)[PER_MACHINE * step : PER_MACHINE * (step + 1)]
        drawn = {len(lines.get_segments()): np.array(lines.get_segments()) for lines in own}
        assert [len(lines.get_segments()) for lines in own] == [3, 6, 4, 2, 6]
        carts = cart_joints(machine, route.q_m[step, :3])
        ends = project(np.stack([carts, carts + link_vectors(machine, route.pose[step], route.q_m[step, :3])], axis=1))
        offsets = np.concatenate([drawn[4] - ends[[0, 1, 3, 5]], drawn[2] - ends[[2, 4]]])
        np.testing.assert_allclose(offsets, np.broadcast_to(offsets[0, 0], offsets.shape), atol=1e-12)


def test_arms_have_the_colour_of_their_mode(machine: Machine, route: Route) -> None:
    """In LRL the links of arm 2 alone are of the other colour."""
    mixed = dataclasses.replace(route, modes=np.full(len(route), MODES.index("LRL")))
    fixed = next(lines for lines in lines_of(machine_figure(machine, mixed)) if len(lines.get_segments()) == 4)
    colours = [to_hex(colour).upper() for colour in fixed.get_colors()]
    assert colours == [style.BLUE, style.ORANGE, style.BLUE, style.BLUE]


def test_long_routes_are_thinned(machine: Machine, route: Route) -> None:
    """More steps than fit are left out evenly, ends kept."""
    rows = np.linspace(0, len(route) - 1, 50).round().astype(int)
    names = ("region", "modes", "gates", "visits", "pose", "q_m", "kappa")
    long = dataclasses.replace(route, **{name: getattr(route, name)[rows] for name in names})
    titles = [text.get_text() for text in machine_figure(machine, long).axes[0].texts if "LLL" in text.get_text()]
    assert len(titles) == MAX_MACHINES
    assert (titles[0], titles[-1]) == ("0  LLL", "49  LLL")


def test_nothing_overlaps(figure: Figure, assert_laid_out: Callable[[Figure], None]) -> None:
    """Drawing and legend keep off each other and stay on the page."""
    assert_laid_out(figure)


@pytest.mark.parametrize("count", [1, 2, 8])
def test_postures_are_named_by_their_modes(
    machine: Machine, count: int, assert_laid_out: Callable[[Figure], None]
) -> None:
    """At poses without a route each machine is named by its working mode, and arms have that mode's colour."""
    controlled = np.tile([1.02, 0.3, 0.9, 0.0, 0.0], (count, 1))
    stances = inverse_kinematics(machine, controlled, np.arange(count))
    figure = postures_figure(machine, stances.pose, stances.q_m)
    titles = [text.get_text() for text in figure.axes[0].texts if text.get_text() in MODES]
    assert titles == list(MODES[:count])
    fixed = [lines for lines in lines_of(figure) if len(lines.get_segments()) == 4]
    sides = {"L": style.BLUE, "R": style.ORANGE}
    for mode, lines in zip(MODES, fixed, strict=False):
        colours = [to_hex(colour).upper() for colour in lines.get_colors()]
        assert colours == [sides[mode[arm]] for arm in (0, 1, 2, 2)]
    assert_laid_out(figure)


def test_a_single_posture_may_be_given_flat(machine: Machine, route: Route) -> None:
    """One pose (6,) with actuators (5,) is one machine, under a title of one's own."""
    figure = postures_figure(machine, route.pose[0], route.q_m[0], ["at the start"])
    assert "at the start" in [text.get_text() for text in figure.axes[0].texts]


def test_bodies_take_the_place_of_lines(
    bodies_machine: Machine, route: Route, assert_laid_out: Callable[[Figure], None]
) -> None:
    """Of links, platform and carts there are outlines in the colours of the arms, and no lines; the floor is behind."""
    figure = postures_figure(bodies_machine, route.pose[0], route.q_m[0])
    assert [len(lines.get_segments()) for lines in lines_of(figure)] == [3, 6]
    floor, bodies = (artist for artist in figure.axes[0].collections if isinstance(artist, PolyCollection))
    assert floor.get_zorder() < bodies.get_zorder()
    assert len(floor.get_paths()) == 12
    colours = {to_hex(colour).upper() for colour in bodies.get_facecolor()}
    assert style.BLUE in colours
    assert style.ORANGE not in colours
    assert "rod of a telescope" in [text.get_text() for text in figure.legends[0].get_texts()]
    names = ("region", "modes", "gates", "visits", "pose", "q_m", "kappa")
    short = dataclasses.replace(route, **{name: getattr(route, name)[:4] for name in names})
    for drawn in (figure, machine_figure(bodies_machine, short)):
        assert_laid_out(drawn)
