"""The benchmark's command line."""

from pathlib import Path
from typing import Annotated, Any

import typer

from pipeline.artifacts import json_bytes, write_whole
from tests.benchmarks.growth import growth
from tests.benchmarks.host import describe_host
from tests.benchmarks.isolated import measure
from tests.benchmarks.problems import Problem, finer_problems, ladder, level_problems, scale_problems
from tests.benchmarks.report import markdown
from tests.benchmarks.resolution import growth_exponent
from tests.benchmarks.side_by_side import compare, headline

_OUT = Path(__file__).parents[2] / "results" / "benchmarks"


def main() -> None:
    """Run the command line."""
    typer.run(benchmark)


def benchmark(
    out: Annotated[Path, typer.Option(help="folder for route.json and route.md")] = _OUT,
    case_limit_s: Annotated[float, typer.Option(min=1.0, help="time limit of each grid of the reference task")] = 400.0,
    peer_limit_s: Annotated[float, typer.Option(min=1.0, help="time limit of each solver on each problem")] = 60.0,
    cases: Annotated[int, typer.Option(min=0, help="grids of the reference task, coarse ones first")] = 99,
    rungs: Annotated[int, typer.Option(min=0, help="problems to compare methods on, small ones first")] = 99,
    grids: Annotated[int, typer.Option(min=0, help="grids of the resolution study, coarse ones first")] = 99,
    only_resolution: Annotated[bool, typer.Option("--only-resolution", help="run the resolution study alone")] = False,
) -> None:
    """Measure stage one on finer and finer grids, side by side with other solvers, and what a finer grid changes."""
    if only_resolution:
        cases = rungs = 0
    results: dict[str, Any] = {
        "host": describe_host(),
        "settings": {"case_limit_s": case_limit_s, "peer_limit_s": peer_limit_s},
    }
    results["cases"] = [_measure_case(problem, case_limit_s) for problem in scale_problems()[:cases]]
    results["growth"] = growth(results["cases"])
    results["instances"] = compare(ladder()[:rungs], peer_limit_s, typer.echo)
    results["headline"] = headline(results["instances"])
    results["resolution"] = _study(grids, case_limit_s)
    write_whole(out / "route.json", json_bytes(results))
    write_whole(out / "route.md", markdown(results).encode())
    typer.echo(f"{out / 'route.md'}")
    if not all(instance.get("agree") for instance in results["instances"]):
        typer.echo("methods disagree: see the table", err=True)
        raise typer.Exit(1)


def _measure_case(problem: Problem, limit_s: float) -> dict[str, Any]:
    typer.echo(f"{problem.name}: stage one by its parts")
    return _figures("scale:measure_parts", problem, limit_s)


def _study(grids: int, limit_s: float) -> dict[str, Any]:
    """Measure what a finer grid changes: for the reference task, and for the machine without tilt."""
    found: dict[str, Any] = {}
    for name, problems, task in (
        ("reference", finer_problems()[:grids], "resolution:measure_optimum"),
        ("level", level_problems()[:grids], "resolution:measure_jump"),
    ):
        found[name] = []
        for problem in problems:
            typer.echo(f"{problem.name}: resolution study, {name} machine")
            found[name].append(_figures(task, problem, limit_s))
        found[f"{name}_exponent"] = growth_exponent(found[name])
    return found


def _figures(task: str, problem: Problem, limit_s: float) -> dict[str, Any]:
    measured = measure(f"tests.benchmarks.{task}", (problem.config,), limit_s)
    return {"name": problem.name, "ended": measured.ended, **measured.figures}
