"""The command that proves what no continuous path can do."""

from collections.abc import Callable

from pipeline.cli.console import results_console
from pipeline.cli.options import ConfigArgument, load_task


def bound(config: ConfigArgument) -> None:
    """Prove what no continuous path can do, with no grid.

    Without tilt a theorem may show that every path meets a Type-II
    singularity; its hypothesis is checked against CONFIG.
    """
    from pipeline.bound.theorem import apply_theorem
    from pipeline.machine.geometry import build_machine
    from pipeline.route.regions.endpoints import task_endpoints

    loaded = load_task(config)
    machine = build_machine(loaded.machine)
    theorem = apply_theorem(loaded, machine, task_endpoints(loaded, machine))
    results_console().print(f"{loaded.name}: {theorem.sentence}.", soft_wrap=True)


COMMANDS: tuple[tuple[Callable[..., None], tuple[str, ...]], ...] = ((bound, ("gantry-tau bound configs/agder.yaml",)),)
"""Every command with its examples."""
