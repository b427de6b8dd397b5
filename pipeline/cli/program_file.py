"""Writing the mixed-integer program of a task as an MPS file, for other solvers and for reading."""

import tempfile
from pathlib import Path

import numpy as np
from rich.console import Console

from pipeline.cli.output import check_output
from pipeline.config import Config
from pipeline.errors import UsageError
from pipeline.machine.geometry import build_machine
from pipeline.machine.rails import with_parallel_rails


def write_program(config: Config, target: Path, console: Console) -> None:
    """Write the program over all regions, visits made and admitted moves; says its exact size before it is built.

    Raises
    ------
    UsageError
        When the task takes more than one program, or the file has no known ending, or is inside a run folder.
    OSError
        When it cannot be written; names the file.
    """
    _check(config, target)
    from pipeline.artifacts.files import naming
    from pipeline.artifacts.output import output_folder, place_output
    from pipeline.route.memory import require_memory
    from pipeline.route.moves.candidates import find_moves
    from pipeline.route.problem import RouteProblem
    from pipeline.route.programs.exclusions import excluded_pairs
    from pipeline.route.programs.whole import WHOLE_PROGRAMS
    from pipeline.route.regions.build import build_regions
    from pipeline.route.search.states import expand_states
    from pipeline.solvers import highs

    machine = with_parallel_rails(build_machine(config.machine))
    with console.status("regions and moves"):
        regions = build_regions(config, machine)
        problem = RouteProblem.of(config, machine, regions, find_moves(config, machine, regions))
        graph = expand_states(regions, problem.moves, np.zeros((0, len(regions)), dtype=bool), config.route)
        exclusions = excluded_pairs(config, graph.regions, graph.moves)
    name, N, count = config.route.formulation, config.route.step_budget, len(graph.regions)
    whole = WHOLE_PROGRAMS[name]
    size = whole.size(count, N, len(exclusions), len(np.unique(exclusions.source)), problem.budgets)
    console.print(
        f"{count:,} regions, N = {N}; the {name} program: {size.columns:,} variables ({size.booleans:,} "
        f"of them boolean), {size.rows:,} rows, {size.entries:,} entries"
    )
    require_memory(config.route, size.built_bytes, "the program", "coarsen route.grid, or lower route.step_budget")
    with console.status(f"writing {target}"):
        program = whole.build(graph.regions, exclusions, problem.steps, N, problem.budgets)
        # Written beside the target and renamed, so that the target is always complete.
        target.parent.mkdir(parents=True, exist_ok=True)
        with naming(target), tempfile.TemporaryDirectory(prefix=".", dir=output_folder(target)) as folder:
            beside = Path(folder) / f"program{target.suffix}"
            highs.write_program(program, beside)
            place_output(beside, target)
    console.print(f"{target}: the {name} program")


def _check(config: Config, target: Path) -> None:
    """Refuse what is not one program, and endings that no solver reads."""
    from pipeline.route.programs.whole import WHOLE_PROGRAMS
    from pipeline.route.search.objective import OBJECTIVES

    options = config.route
    if options.formulation not in WHOLE_PROGRAMS:
        raise UsageError(f"--write-mps goes with {' or '.join(f'--formulation {name}' for name in WHOLE_PROGRAMS)}")
    if not OBJECTIVES[options.objective].single_program:
        single = " or ".join(name for name, objective in OBJECTIVES.items() if objective.single_program)
        raise UsageError(f"--write-mps goes with route.objective {single}: {options.objective} needs several programs")
    if options.alternative > 1:
        rank = options.alternative
        raise UsageError(f"--write-mps goes with route.alternative 1: number {rank} needs the better routes first")
    if target.suffix not in (".mps", ".lp"):
        raise UsageError(f"--write-mps {target}: the name of the file must end in .mps (or .lp)")
    check_output(target, option="--write-mps")
