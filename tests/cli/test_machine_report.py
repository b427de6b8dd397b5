"""A machine and its task as tables."""

from io import StringIO
from typing import Any

from rich.console import Console

from pipeline.cli.machine_report import machine_report
from pipeline.config import Config
from pipeline.machine import Machine
from pipeline.route import task_endpoints


def test_empty_reach_is_shown(fast_config: Config, machine: Machine, change: Any) -> None:
    """An empty reach reads "none"."""
    console = Console(file=StringIO(), width=110)
    ends = task_endpoints(fast_config, machine)
    for part in machine_report(change(fast_config, route__kappa_max=2.0), machine, ends):
        console.print(part)
    assert "none" in console.file.getvalue()
