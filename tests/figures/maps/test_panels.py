"""Maps of kappa as a figure of their own."""

from collections.abc import Callable

import numpy as np
import pytest
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure

from pipeline.figures.maps.kappa_map import KappaMap, kappa_map
from pipeline.figures.maps.panels import kappa_map_figure, map_norm
from pipeline.machine import MODES, Machine

Y, Z = np.linspace(-0.4, 1.2, 33), np.linspace(0.3, 1.4, 23)


@pytest.fixture(scope="module")
def maps(machine: Machine) -> dict[str, KappaMap]:
    """Give the maps of all working modes without tilt."""
    return {name: kappa_map(machine, Y, Z, (0.0, 0.0), mode) for mode, name in enumerate(MODES)}


def test_a_panel_per_map(maps: dict[str, KappaMap]) -> None:
    """Every map has a panel under its title, in one scale; loops are drawn where det H changes sign and only there."""
    *panels, _ = kappa_map_figure(maps).axes
    assert [axes.get_title() for axes in panels] == list(MODES)
    assert len({axes.get_images()[0].norm for axes in panels}) == 1
    for axes, a_map in zip(panels, maps.values(), strict=True):
        loops = [artist for artist in axes.get_children() if isinstance(artist, ContourSet)]
        assert bool(loops) == a_map.has_singularities


@pytest.mark.parametrize("count", [1, 2, 5, 8])
def test_it_is_laid_out(maps: dict[str, KappaMap], count: int, assert_laid_out: Callable[[Figure], None]) -> None:
    """Panels, colour bar and legend keep off each other, however many maps there are."""
    assert_laid_out(kappa_map_figure(dict(list(maps.items())[:count])))


def test_scale_of_maps_out_of_reach() -> None:
    """Maps without a value have a scale, too."""
    nothing = KappaMap(Y, Z, np.full((23, 33), np.nan), np.full((23, 33), np.nan))
    norm = map_norm([nothing], 100.0)
    assert 0.0 < norm.vmin < norm.vmax == 100.0
    kappa_map_figure({"nothing": nothing}).draw_without_rendering()
