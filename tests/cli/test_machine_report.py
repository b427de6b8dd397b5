"""A machine and its task as tables."""

from dataclasses import replace
from io import StringIO
from typing import Any

import numpy as np
from rich.console import Console

from pipeline.cli.machine_report import machine_report
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
