"""The set-up of `make run` from an empty clone, beside pip and beside what development needs, in turns.

`python -m tests.benchmarks.setting_up` writes `setup.json` and `setup.md` into `results/benchmarks`. The caches of uv
and pip are as they are on this machine: one round that is not counted fills them.
"""

import os
import shlex
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median
from typing import Annotated, Any

import typer

from pipeline.artifacts import json_bytes, write_whole
from tests.benchmarks.host import describe_host
from tests.benchmarks.report import table

_ROOT = Path(__file__).parents[2]
_OUT = _ROOT / "results" / "benchmarks"
_VENV = f"{shlex.quote(sys.executable)} -m venv .venv"
_PIP = ".venv/bin/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt"
_WAYS = {
    "make run: uv, a run's packages": "make .venv/.run.ready",
    "make test: uv, all that development needs": "make .venv/.dev.ready",
    "pip, a run's packages": f"{_VENV} && {_PIP} --editable .",
    "pip, all that development needs": f"{_VENV} && {_PIP} --editable '.[dev]'",
}
"""What is compared: the last is how `make run` began until uv and sets came."""


def benchmark(
    out: Annotated[Path, typer.Option(help="folder for setup.json and setup.md")] = _OUT,
    repeats: Annotated[int, typer.Option(min=1, help="set-ups of each kind, of which medians are taken")] = 5,
    ends: Annotated[bool, typer.Option("--ends", help="measure the first and the last kind only")] = False,
) -> None:
    """Set up from an empty clone again and again."""
    host, ways = describe_host(), list(_WAYS.items())
    ways = [ways[0], ways[-1]] if ends else ways
    seconds: dict[str, list[float]] = {way: [] for way, _ in ways}
    for number in range(repeats + 1):
        for way, command in ways:
            took = _set_up(command)
            typer.echo(f"{number}: {way}: {took:.1f} s")
            if number:
                seconds[way].append(took)
    write_whole(out / "setup.json", json_bytes({"host": host, "seconds": seconds}))
    write_whole(out / "setup.md", setup_page(host, seconds).encode())


def setup_page(host: dict[str, Any], seconds: dict[str, list[float]]) -> str:
    """Write the page: the median of each way, and its ratio to the slowest."""
    medians = {way: median(values) for way, values in seconds.items()}
    slowest = max(medians.values())
    rows = [
        (way, f"{value:.1f}", f"{value / slowest:.2f}", f"{min(seconds[way]):.1f} to {max(seconds[way]):.1f}")
        for way, value in medians.items()
    ]
    repeats = len(next(iter(seconds.values())))
    parts = [
        "# Set-up",
        "Written by `make bench-setup`. Seconds from an empty clone to a program that runs: a virtual environment with "
        f"the pinned packages, medians of {repeats}, in turns. The packages were in the caches of pip and uv; pip "
        "installs uv each time.",
        f"On {str(host['date'])[:10]}: {host['cpu']}, {host['cores']} cores, load {host['load_before']:.1f} before the "
        "start.",
        table(("set-up", "seconds", "of the slowest", "least to most"), rows),
    ]
    return "\n\n".join(parts) + "\n"


def _set_up(command: str) -> float:
    """Time a set-up in an empty clone of what is committed."""
    environment = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "VIRTUAL_ENV")}
    with tempfile.TemporaryDirectory() as folder:
        archive = subprocess.run(["git", "archive", "HEAD"], cwd=_ROOT, check=True, capture_output=True).stdout
        subprocess.run(["tar", "-x"], cwd=folder, check=True, input=archive)
        began = time.perf_counter()
        subprocess.run(
            ["bash", "-c", command],
            cwd=folder,
            env=environment,
            check=True,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        return time.perf_counter() - began


if __name__ == "__main__":
    typer.run(benchmark)
