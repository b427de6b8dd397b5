"""Bodies on the page: where they are, which are red, and that they can be left out."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from pipeline.machine import Machine
from pipeline.machine.bodies.meshes import body_meshes, mesh_frame
from pipeline.machine.drawing import drawn_points
from pipeline.machine.shapes.model import FrameKind
from pipeline.report import Report, render_page
from pipeline.report.palette import LIGHT
from tests.report.browser import why_none
from tests.report.opened import DESKTOP, Opened

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(bool(why_none()), reason=why_none() or "-"),
]

MOVING = 9
SEEN = "() => document.getElementById('machine').data.filter(t => t.visible !== false).map(t => t.name)"
NEAREST = "i => document.getElementById('timeline').data.filter(t => t.text).map(t => [t.name, t.text[i], t.y[i]])"
COLOURS = "() => [9, 10].map(k => document.getElementById('machine').data[k].facecolor)"


@pytest.fixture(scope="module")
def opened(browser: Any, bodies_report: Report, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Opened]:
    """Open the page of a run with bodies; its nearest pair is red throughout."""
    scene = replace(bodies_report.scene, alarm_m=1.0)
    path = tmp_path_factory.mktemp("bodies") / "report.html"
    path.write_text(render_page(replace(bodies_report, scene=scene)), encoding="utf-8")
    page = Opened(browser, path, DESKTOP)
    yield page
    page.page.close()


def test_bodies_are_drawn_where_they_are(opened: Opened, bodies_report: Report, bodies_machine: Machine) -> None:
    """All corners of all moving bodies are those that the program places, in the order of the bodies."""
    motion, frame = bodies_report.motions[0], 60
    opened.go_to(frame)
    points = drawn_points(bodies_machine, motion.pose[frame], motion.q_m[frame])
    meshes = [mesh for mesh in body_meshes(bodies_machine) if mesh.kind != FrameKind.FIXED]
    expected = np.vstack([mesh_frame(mesh, motion.pose[frame], points).place(mesh) for mesh in meshes])
    assert np.allclose(opened.trace(MOVING).T, expected, atol=1e-5)
    assert opened.complaints() == []


def test_the_nearest_pair_is_named_and_red(opened: Opened, bodies_report: Report) -> None:
    """Its triangles alone have the colour, and the values beside the map say which it is and how near."""
    motion, frame = bodies_report.motions[0], 30
    opened.go_to(frame)
    scene, (pair, distance_m) = bodies_report.scene, motion.nearest_at(frame)
    red = [colour == LIGHT.near for colours in opened.page.evaluate(COLOURS) for colour in colours]
    assert sum(red) == sum(len(scene.meshes[number].faces) for number in scene.pairs[pair])
    text = opened.page.locator("#readout .bodies").inner_text()
    assert f"{1e3 * distance_m:.1f} mm: {scene.pair_names[pair]}" in text
    assert opened.page.locator("#readout .near").count() == 1


def test_distances_over_time_name_their_pairs(opened: Opened, bodies_report: Report) -> None:
    """There is a curve of the nearest bodies and one of the nearest obstacle, with the pair at every instant."""
    motion, names = bodies_report.motions[0], bodies_report.scene.pair_names
    for frame in (0, 60):
        found = opened.page.evaluate(NEAREST, frame)
        for (of, name, distance_mm), group in zip(found, motion.nearest, strict=True):
            assert (of, name) == (group.of, names[group.pair[frame]])
            assert abs(distance_mm - 1e3 * group.distance_m[frame]) < 1e-3


def test_bodies_can_be_left_out(opened: Opened) -> None:
    """Without them there are lines and bars in their place, and with them again these are gone."""
    lines = {"fixed links", "telescopes", "platform", "rails"}
    opened.page.locator("#bodies").uncheck()
    seen = set(opened.page.evaluate(SEEN))
    assert lines <= seen
    assert not {"bodies", "fixed bodies", "bodies around"} & seen
    opened.page.locator("#bodies").check()
    seen = set(opened.page.evaluate(SEEN))
    assert not lines & seen
    assert {"bodies", "fixed bodies", "bodies around"} <= seen


def test_axe_finds_nothing(opened: Opened) -> None:
    """The legend with its box, and the values, are accessible in both themes."""
    from axe_playwright_python.sync_playwright import Axe

    for theme in ("dark", "light"):
        opened.page.emulate_media(color_scheme=theme)
        result = Axe().run(opened.page, context="#motion")
        assert result.violations_count == 0, result.generate_report()
