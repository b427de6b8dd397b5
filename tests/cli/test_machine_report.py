"""A machine and its task as tables."""

from dataclasses import replace
from io import StringIO
from typing import Any

import numpy as np
from rich.console import Console

from pipeline.cli.machine_report import machine_report, refused_report
from pipeline.config import Config
from pipeline.machine import Machine
from pipeline.route import task_endpoints


def test_what_the_drives_feel_is_shown(fast_config: Config, machine: Machine) -> None:
    """Masses, stiffness with its direction and amplification; without masses amplification alone, and why."""
    ends = task_endpoints(fast_config, machine)
    shown = []
    for one in (machine, replace(machine, masses=None, force_n=np.full((2, 5), np.inf), link_force_n=np.inf)):
        console = Console(file=StringIO(), width=110)
        for part in machine_report(fast_config, one, ends):
            console.print(part)
        shown.append(console.file.getvalue().split("Drives")[1])
    for text in ("reflected mass of l3b", "in the worst direction", "gravity stiffness", "l2b", "mm/mm", "mrad/mm"):
        assert text in shown[0]
    assert "no masses are given" in shown[1]
    assert "reflected mass" not in shown[1]
    assert "mrad/mm" in shown[1]


def test_empty_reach_is_shown(fast_config: Config, machine: Machine, change: Any) -> None:
    """An empty reach reads "none"."""
    console = Console(file=StringIO(), width=110)
    ends = task_endpoints(fast_config, machine)
    for part in machine_report(change(fast_config, route__kappa_max=2.0), machine, ends):
        console.print(part)
    assert "none" in console.file.getvalue()


def test_bodies_and_their_distances_are_listed(bodies_config: Config, bodies_machine: Machine) -> None:
    """Bodies, what touches by construction, and the nearest pairs with those of obstacles; nothing without bodies."""
    console = Console(file=StringIO(), width=120)
    for part in machine_report(bodies_config, bodies_machine, task_endpoints(bodies_config, bodies_machine)):
        console.print(part)
    text = console.file.getvalue()
    listed, touching, distances = (text.split(title)[1] for title in ("Bodies:", "Bodies that touch", "Distances of"))
    assert "pairs are kept 0.005 m apart" in listed
    for name in ("saddle1", "cart 1", "rail 3", "post4", "frame"):
        assert name in listed.split("Bodies that touch")[0]
    assert "checked beyond 0.08 m from it" in touching
    assert distances.index("spine and rod 2b") < distances.index("rib3b and rod 3b")
    assert "more pairs are farther apart" in distances


def test_every_obstacle_has_a_distance(bodies_config: Config, bodies_machine: Machine, vary: Any) -> None:
    """However far away it is; and it is told from bodies of the frame."""
    box = {"size_m": [0.1, 0.1, 0.1], "centre_m": [1.9, 1.1, 0.1]}
    config = vary(bodies_config, {"task.obstacles": [{"name": "workpiece", "box": box}]})
    console = Console(file=StringIO(), width=120)
    for part in machine_report(config, bodies_machine, task_endpoints(config, bodies_machine)):
        console.print(part)
    listed, distances = console.file.getvalue().split("Distances of")
    assert "workpiece │ nothing, an obstacle" in listed
    assert "and workpiece" in distances


def test_of_one_end_within_reach_distances_are_listed(bodies_config: Config, bodies_machine: Machine) -> None:
    """The tables that need both ends are left out."""
    start, _ = task_endpoints(bodies_config, bodies_machine)
    console = Console(file=StringIO(), width=120)
    for part in refused_report(bodies_config, bodies_machine, {"start": start}):
        console.print(part)
    text = console.file.getvalue()
    assert "start m" in text.split("Distances of")[1]
    assert "goal m" not in text
    assert "working mode" in text
    assert "sign of det H" not in text
