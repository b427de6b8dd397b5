"""A problem as files, which every method reads in a process of its own.

`config.yaml`, `regions.npz` (the region table, and the pairs no step may join) and `compact.mps` (the compact
program, for solvers that read files).
"""

from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.config import Config
from pipeline.config.file import dump_config, load_config
from pipeline.machine import build_machine
from pipeline.route import RegionTable, build_regions
from pipeline.route.bounds.shortest_paths import fewest_positions
from pipeline.route.metric import step_sizes
from pipeline.route.moves.candidates import Moves, find_moves
from pipeline.route.programs.compact import build_compact
from pipeline.route.programs.exclusions import excluded_pairs
from pipeline.solvers import write_program
from tests.benchmarks.peers.reading import PROGRAM, REGIONS

CONFIG = "config.yaml"


def save_config(config: Config, folder: Path) -> None:
    """Begin the folder of a problem."""
    (folder / CONFIG).write_text(dump_config(config), encoding="utf-8")


def prepare(folder: Path, with_program: bool) -> Iterator[dict[str, Any]]:
    """Compute what the methods share and write it beside the configuration."""
    config = load_problem(folder)
    machine = build_machine(config.machine)
    regions = build_regions(config, machine)
    moves = find_moves(config, machine, regions)
    excluded = excluded_pairs(config, regions, moves)
    steps, budget = step_sizes(config.route), config.route.step_budget
    np.savez(
        folder / REGIONS,
        steps=steps,
        step_budget=np.array(budget),
        excluded_source=excluded.source,
        excluded_target=excluded.target,
        **asdict(regions),
    )
    if with_program:
        write_program(build_compact(regions, excluded, steps, budget), folder / PROGRAM)
    yield {
        "regions": len(regions),
        "gates": regions.gate_count,
        "moves": len(moves),
        "excluded": len(excluded),
        "step_budget": budget,
        "fewest_positions": fewest_positions(regions, moves) or 1,
    }


def load_problem(folder: Path) -> Config:
    """Read the configuration."""
    return load_config(folder / CONFIG)


def load_regions(folder: Path) -> RegionTable:
    """Read the region table."""
    with np.load(folder / REGIONS) as arrays:
        return RegionTable(**{name: arrays[name] for name in RegionTable.__dataclass_fields__})


def load_exclusions(folder: Path) -> Moves:
    """Read the pairs that no step may join."""
    with np.load(folder / REGIONS) as arrays:
        return Moves(arrays["excluded_source"], arrays["excluded_target"])
