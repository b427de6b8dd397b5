"""Writing the mixed-integer program of a task as an MPS file, for other solvers and for reading."""

import tempfile
from pathlib import Path

import numpy as np
from rich.console import Console

from pipeline.config import Config
from pipeline.config.choices import Formulation, RouteObjective
from pipeline.errors import UsageError
from pipeline.machine.geometry import build_machine


def write_program(config: Config, target: Path, console: Console) -> None:
    """Write the program over all regions, visits and admitted moves; report its exact size first.

    Raises
    ------
    UsageError
        When the task needs more than one program, or the file has no known ending.
    """
    _check(config, target)
    from pipeline.route.bounds.budgets import budgets
    from pipeline.route.metric import step_sizes
    from pipeline.route.moves.candidates import find_moves
    from pipeline.route.programs.compact import build_compact_model
    from pipeline.route.programs.exclusions import excluded_pairs
    from pipeline.route.programs.paper import build_paper_model, paper_size
    from pipeline.route.regions.build import build_regions
    from pipeline.route.search.states import expand_states
    from pipeline.solvers.highs import write_model

    machine = build_machine(config.machine)
    with console.status("regions and moves"):
        regions = build_regions(config, machine)
        layout = expand_states(regions, find_moves(config, machine, regions), np.zeros((0, len(regions)), dtype=bool))
        exclusions = excluded_pairs(config, layout.regions, layout.moves)
    N = config.route.step_budget
    count = len(layout.regions)
    size = paper_size(count, N, len(exclusions), len(np.unique(exclusions.source)), budgets(config))
    console.print(
        f"{count:,} regions, N = {N}; the paper's program: {size.columns:,} variables ({size.booleans:,} "
        f"of them boolean), {size.rows:,} rows, {size.entries:,} entries"
    )
    build = build_paper_model if config.route.formulation == Formulation.PAPER else build_compact_model
    with console.status(f"writing {target}"):
        model = build(layout.regions, exclusions, step_sizes(config.route), N, budgets(config))
        # Written beside the target and renamed, so that the target is always complete.
        with tempfile.TemporaryDirectory(dir=target.parent) as folder:
            beside = Path(folder) / f"program{target.suffix}"
            write_model(model, beside)
            beside.replace(target)
    console.print(f"{target}: the {config.route.formulation} program")


def _check(config: Config, target: Path) -> None:
    """Refuse tasks that are not a single program, and endings that no solver reads."""
    if config.route.formulation == Formulation.CORE:
        raise UsageError("--write-mps goes with --formulation paper or --formulation compact")
    if config.route.objective != RouteObjective.SUM:
        raise UsageError(f"--write-mps goes with route.objective sum: {config.route.objective} needs several programs")
    if config.route.alternative > 1:
        rank = config.route.alternative
        raise UsageError(f"--write-mps goes with route.alternative 1: number {rank} needs the better routes first")
    if target.suffix not in (".mps", ".lp"):
        raise UsageError(f"--write-mps {target}: the name of the file must end in .mps (or .lp)")
