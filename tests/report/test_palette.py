"""Colours can be told apart by everyone, and stand out from their ground."""

from dataclasses import asdict
from itertools import combinations

import numpy as np
import pytest

from pipeline.report.palette import DARK, LIGHT, MAP, SINGULAR, Palette

# Machado, Oliveira and Fernandes (2009), severity 1, in linear RGB.
_PROTANOPIA = [0.152286, 1.052583, -0.204868, 0.114503, 0.786281, 0.099216, -0.003882, -0.048116, 1.051998]
_DEUTERANOPIA = [0.367322, 0.860646, -0.227968, 0.280085, 0.672501, 0.047413, -0.011820, 0.042940, 0.968881]
_TRITANOPIA = [1.255528, -0.076749, -0.178779, -0.078411, 0.930809, 0.147602, 0.004733, 0.691367, 0.303900]
SIGHT = {
    "normal": np.eye(3),
    "protanopia": np.reshape(_PROTANOPIA, (3, 3)),
    "deuteranopia": np.reshape(_DEUTERANOPIA, (3, 3)),
    "tritanopia": np.reshape(_TRITANOPIA, (3, 3)),
}
# Ottosson's OKLab.
_CONES = [0.41222147, 0.53633254, 0.05144599, 0.21190350, 0.68069955, 0.10739696, 0.08830246, 0.28171884, 0.62997870]
_OPPONENTS = [0.21045426, 0.79361779, -0.00407205, 1.97799850, -2.42859221, 0.45059371, 0.02590404, 0.78277177]
CONES, OPPONENTS = np.reshape(_CONES, (3, 3)), np.reshape([*_OPPONENTS, -0.80867577], (3, 3))

CURVES = (("first", "second", "third"), ("refined", "coarse", "bound"))
"""What is drawn in one plot."""
SCENE = ("first", "third", "refined", "rail", "platform")
"""Lines and bodies in 3-D."""


def linear(colour: str) -> np.ndarray:
    """Convert #rrggbb to linear RGB."""
    value = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def contrast(one: str, other: str) -> float:
    """Compute the contrast of WCAG 2."""
    dark, light = sorted(float(linear(colour) @ [0.2126, 0.7152, 0.0722]) for colour in (one, other))
    return (light + 0.05) / (dark + 0.05)


def distance(one: str, other: str, sight: np.ndarray) -> float:
    """Compute how different two colours look, as a distance in OKLab."""
    seen = (OPPONENTS @ np.cbrt(CONES @ np.clip(sight @ linear(colour), 0.0, 1.0)) for colour in (one, other))
    return float(np.linalg.norm(np.subtract(*seen)))


def test_the_simulation_is_right() -> None:
    """Black against white is 21 and 1; red and green of one lightness fall together without one kind of cones."""
    assert contrast("#000000", "#FFFFFF") == pytest.approx(21.0)
    assert distance("#000000", "#FFFFFF", SIGHT["normal"]) == pytest.approx(1.0, abs=1e-3)
    red, green = "#C06040", "#808040"
    assert distance(red, green, SIGHT["deuteranopia"]) < 0.4 * distance(red, green, SIGHT["normal"])


@pytest.mark.parametrize("palette", [LIGHT, DARK])
@pytest.mark.parametrize("sight", SIGHT)
def test_curves_differ_for_everyone(palette: Palette, sight: str) -> None:
    """Any two curves of a plot, or lines of the scene, look different, whatever cones one lacks."""
    colours = asdict(palette)
    for group in (*CURVES, SCENE):
        for one, other in combinations(group, 2):
            least = 0.13 if group in CURVES else 0.1
            assert distance(colours[one], colours[other], SIGHT[sight]) >= least, (one, other)


@pytest.mark.parametrize("palette", [LIGHT, DARK])
@pytest.mark.parametrize("sight", SIGHT)
def test_bodies_that_turn_red_differ(palette: Palette, sight: str) -> None:
    """Links, telescopes and platform look different when they are of the nearest pair, which is named as well."""
    for body in ("first", "third", "platform"):
        assert distance(palette.near, asdict(palette)[body], SIGHT[sight]) >= 0.1, body


@pytest.mark.parametrize("palette", [LIGHT, DARK])
def test_everything_stands_out(palette: Palette) -> None:
    """Text has the contrast of WCAG AA, curves and signs that of graphics, on the page and on its panels."""
    for ground in (palette.ground, palette.panel):
        for text in (palette.text, palette.soft, palette.good, palette.bad, palette.open):
            assert contrast(text, ground) >= 4.5
        for group in (*CURVES, SCENE, ("frame", "near", "limit", "change", "focus")):
            assert all(contrast(asdict(palette)[name], ground) >= 3.0 for name in group)
    assert contrast(palette.button, palette.focus) >= 4.5


def test_singular_curves_stand_out_from_the_map() -> None:
    """They run where kappa is large: on the dark end of the map; its light end is far from its dark one."""
    assert contrast(SINGULAR, MAP[-1]) >= 4.5
    assert contrast(MAP[0], MAP[-1]) >= 4.5
    lightness = [float(linear(colour) @ [0.2126, 0.7152, 0.0722]) for colour in MAP]
    assert lightness == sorted(lightness, reverse=True)
