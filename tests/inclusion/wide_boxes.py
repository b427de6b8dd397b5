"""Boxes that are wider than any proof needs, along a short path of a platform that gravity turns."""

from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

import numpy as np
from flint import arb

from pipeline.inclusion.closure import geometry, working_precision
from pipeline.inclusion.krawczyk import Box, along, include
from pipeline.inclusion.pieces import pieces
from pipeline.inclusion.proven_box import ProvenBox
from pipeline.machine import Machine
from pipeline.machine.masses import Masses
from pipeline.refine import Path

T = TypeVar("T")
FIRST = 0.3


def heavy(machine: Machine, length_m: float) -> Machine:
    """Give a platform whose centre of mass is far from the tool centre point, with a characteristic length."""
    masses = replace(machine.known_masses, platform_kg=200.0, platform_centre_m=np.array([0.6, 0.5, -0.4]))
    return replace(machine, masses=masses, characteristic_length_m=length_m)


def wide_box(path: Path, width: float, radius: float) -> Box:
    """Follow the path by a cubic over an interval that begins at a knot."""
    first = next(part.first for part in pieces(path.spline) if part.first >= FIRST)
    s = first + width * np.linspace(0.0, 1.0, 9)
    cubic = np.polynomial.polynomial.polyfit(s - (first + width / 2.0), path.pose(s), 3)
    return Box(first, first + width, cubic, np.full(6, radius))


def bounded_in_balls(bound: Callable[[ProvenBox, Masses], T], path: Path, box: Box, deviation: np.ndarray) -> T:
    """Bound a quantity in ball arithmetic, as if poses were proven to deviate by no more than `deviation` (6,)."""
    with working_precision(64):
        balls = geometry(path.machine)
        piece = next(part for part in pieces(path.spline) if part.first <= box.first and box.last <= part.last)
        series = along(balls, piece, box)
        inclusion = include(balls, series, box)
        assert inclusion is not None
        image = [arb(value) for value in deviation.tolist()]
        wide = ProvenBox(path.machine, balls, piece, series, replace(inclusion, image=image))
        return bound(wide, path.machine.known_masses)
