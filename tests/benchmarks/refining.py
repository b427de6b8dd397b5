"""Stage two measured: meshes, cold and warm, other solvers and formulations, random tasks; `make bench-refine`."""

import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from pipeline.artifacts import json_bytes, write_whole
from pipeline.config import Config
from pipeline.config.file import load_config
from pipeline.errors import NoSolutionError
from pipeline.refine import measure_path as measure_samples
from pipeline.refine import refine_path, sample_path
from pipeline.refine.integral.minimise import minimise_integral
from pipeline.refine.mesh import Mesh, even_mesh, midpoints
from pipeline.refine.peak.lower import lower_peak
from pipeline.refine.problem import MeshSolution, Problem, fit_coarse, transfer_to
from tests.benchmarks.host import describe_host
from tests.benchmarks.isolated import FINISHED, measure
from tests.benchmarks.problems import CONFIGS
from tests.benchmarks.refining_peers import SOLVERS, problem_of
from tests.benchmarks.report import table
from tests.benchmarks.variety import random_machines, random_tasks

_OUT = Path(__file__).parents[2] / "results" / "benchmarks"
MESHES = ((50, 15), (50, 20), (100, 30), (100, 60), (200, 30), (200, 60), (400, 60), (400, 120))
SMALL = (50, 20)
"""Nodes and coefficients on which all methods are compared."""
_TASK_LIMIT_S = 300.0
OBJECTIVES = ("integral", "mixed", "maximum")


def main() -> None:
    """Run the command line."""
    typer.run(benchmark)


def benchmark(
    out: Annotated[Path, typer.Option(help="folder for refine.json and refine.md")] = _OUT,
    limit_s: Annotated[float, typer.Option(min=1.0, help="time limit of each method")] = 120.0,
    meshes: Annotated[int, typer.Option(min=0, help="meshes, coarse ones first")] = len(MESHES),
    tasks: Annotated[int, typer.Option(min=0, help="random tasks")] = 20,
    machines: Annotated[int, typer.Option(min=0, help="random machines")] = 5,
) -> None:
    """Measure stage two on the reference task, side by side with other ways, and on random tasks and machines."""
    agder, quick = load_config(CONFIGS / "agder.yaml"), load_config(CONFIGS / "quick.yaml")
    results: dict[str, Any] = {"host": describe_host(), "settings": {"limit_s": limit_s}}
    results["meshes"] = [_measured("measure_mesh", agder, *mesh, limit_s=limit_s) for mesh in MESHES[:meshes]]
    results["stage"] = [
        {"objective": objective, **_measured("measure_stage", agder, objective, limit_s=limit_s)}
        for objective in OBJECTIVES
    ]
    results["methods"] = [{"method": name, **figures} for name, figures in _methods(quick, limit_s)]
    problems = [*random_tasks(tasks), *random_machines(machines)]
    results["variety"] = [
        {
            "problem": problem.name,
            **measure("tests.benchmarks.variety:measure_refinement", (problem.config,), 300).figures,
        }
        for problem in problems
    ]
    write_whole(out / "refine.json", json_bytes(results))
    write_whole(out / "refine.md", markdown(results).encode())
    typer.echo(f"{out / 'refine.md'}")


def _measured(task: str, *arguments: object, limit_s: float, module: str = "refining") -> dict[str, Any]:
    typer.echo(f"{task}: {' '.join(str(a) for a in arguments if not isinstance(a, Config))}")
    found = measure(f"tests.benchmarks.{module}:{task}", arguments, limit_s)
    return found.figures if found.ended == FINISHED else {**found.figures, "ended": found.ended}


def _methods(config: Config, limit_s: float) -> Iterator[tuple[str, dict[str, Any]]]:
    peers = {"limit_s": limit_s, "module": "refining_peers"}
    yield "descent (ours)", _measured("measure_descent", config, *SMALL, limit_s=limit_s)
    for solver in SOLVERS:
        yield f"lifted, {solver}", _measured("solve_program", config, *SMALL, solver, True, **peers)
    yield "not lifted, ipopt", _measured("solve_program", config, *SMALL, "ipopt", False, **peers)
    for method in ("SLSQP", "trust-constr"):
        yield f"coefficients alone, SciPy's {method}", _measured("solve_with_scipy", config, *SMALL, method, **peers)


def measure_mesh(config: Config, nodes: int, coefficients: int) -> Iterator[dict[str, Any]]:
    """Solve on one mesh: cold by IPOPT, then the descent; and warm, from a mesh half as fine."""
    problem = problem_of(config)
    yield {"nodes": nodes, "coefficients": coefficients}
    mesh = even_mesh(nodes, coefficients, np.zeros(0))
    begun = time.perf_counter()
    cold = minimise_integral(problem, fit_coarse(problem, mesh))
    yield {"ipopt_s": time.perf_counter() - begun, "ipopt_iterations": cold.iterations}
    begun = time.perf_counter()
    final = lower_peak(problem, cold)
    yield {"descent_s": time.perf_counter() - begun, "descent_steps": final.iterations - cold.iterations}
    yield _figures(problem, final)
    # All spans halved: the finer mesh contains the coarser one.
    half = even_mesh(max(nodes // 2, 20), max(coefficients // 2, 8), np.zeros(0))
    try:
        before = lower_peak(problem, minimise_integral(problem, fit_coarse(problem, half)))
    except NoSolutionError:
        yield {"ended": "no path on the mesh half as fine"}
        return
    knots = np.sort(np.concatenate([half.knots, midpoints(np.unique(half.knots))]))
    finer = Mesh(np.union1d(half.s, midpoints(half.s)), knots)
    begun = time.perf_counter()
    warm = lower_peak(problem, transfer_to(before, finer))
    yield {"warm_s": time.perf_counter() - begun, "warm_steps": warm.iterations - before.iterations}


def measure_stage(config: Config, objective: str) -> Iterator[dict[str, Any]]:
    """Run the whole stage with an objective."""
    problem = problem_of(
        config.model_copy(update={"refine": config.refine.model_copy(update={"objective": objective})})
    )
    begun = time.perf_counter()
    result = refine_path(problem.config, problem.machine, problem.route)
    yield {
        "seconds": time.perf_counter() - begun,
        "iterations": result.iterations,
        "rounds": result.rounds,
        "meshes": result.meshes,
        "nodes": result.nodes,
        "coefficients": len(result.path.spline.c),
        "surrogate": result.surrogate_integral,
    }
    for name, path in (("", result.path), ("coarse_", result.coarse)):
        figures = measure_samples(sample_path(path, np.linspace(0.0, 1.0, 20_001)), problem.steps)
        yield {f"{name}kappa_integral": figures.kappa_integral, f"{name}kappa_max": figures.kappa_max}


def measure_descent(config: Config, nodes: int, coefficients: int) -> Iterator[dict[str, Any]]:
    """Descend from the splines fitted to the coarse path, without IPOPT before."""
    problem = problem_of(config)
    initial = fit_coarse(problem, even_mesh(nodes, coefficients, np.zeros(0)))
    begun = time.perf_counter()
    solution = lower_peak(problem, initial)
    yield {
        "solve_s": time.perf_counter() - begun,
        "iterations": solution.iterations,
        "unknowns": solution.path.spline.c.size,
        "outcome": "solved",
        **_figures(problem, solution),
    }


def _figures(problem: Problem, solution: MeshSolution) -> dict[str, float]:
    figures = measure_samples(sample_path(solution.path, np.linspace(0.0, 1.0, 20_001)), problem.steps)
    return {"kappa_integral": figures.kappa_integral, "kappa_max": figures.kappa_max}


def markdown(results: dict[str, Any]) -> str:
    """Write all results as one page."""
    variety = results["variety"]
    solved = sum(row.get("outcome") == "path" for row in variety)
    sections = [
        "# Benchmark of stage two",
        "Written by `make bench-refine`; every number is in `refine.json`. Seconds are wall-clock, each measurement in "
        f"a process of its own, on {results['host']['cpu']}, {results['host']['cores']} cores, "
        f"{results['host']['date']}, load {results['host']['load_before']:.2f} before the start.",
        "## Meshes",
        "`agder.yaml`, even meshes. IPOPT from the coarse path (rough Frobenius solve, then Schatten), then the "
        "descent in actuator space. *Warm*: the descent alone, from the path of a mesh half as fine, its "
        "spans halved.",
        _rows(
            results["meshes"],
            ("nodes", "coefficients", "ipopt_s", "ipopt_iterations", "descent_s", "descent_steps"),
            ("warm_s", "warm_steps", "kappa_integral", "kappa_max", "ended"),
        ),
        "## The whole stage",
        "`agder.yaml` with the default mesh, finer meshes and the check between the nodes.",
        _rows(
            results["stage"],
            ("objective", "seconds", "iterations", "meshes", "rounds", "nodes", "coefficients"),
            ("kappa_integral", "surrogate", "coarse_kappa_integral", "kappa_max", "coarse_kappa_max", "ended"),
        ),
        "## Other ways",
        f"`quick.yaml`, {SMALL[0]} nodes and {SMALL[1]} coefficients, from the splines fitted to the coarse path, "
        f"{results['settings']['limit_s']:g} s each. The programs minimise the integral of the Frobenius kappa, "
        "written out for solvers that differentiate themselves; *not lifted* has no actuators of nodes among its "
        "unknowns; SciPy's have the coefficients alone, and limits and slopes of the descent.",
        _rows(
            results["methods"],
            ("method", "unknowns", "build_s", "solve_s", "iterations", "objective"),
            ("kappa_integral", "kappa_max", "outcome", "ended"),
        ),
        "## Random tasks and machines",
        f"A path for {solved} of {len(variety)}, every limit kept at 100,000 places. Tasks on the grid of "
        "`quick.yaml`, start and goal anywhere in any working mode; machines up to five per cent off in every joint.",
        _rows(
            variety,
            ("problem", "outcome", "positions", "refine_s", "iterations", "rounds", "nodes"),
            ("kappa_integral", "kappa_integral_change", "kappa_max", "coarse_kappa_max", "reason"),
        ),
    ]
    return "\n\n".join(sections) + "\n"


def _rows(rows: Sequence[dict[str, Any]], *columns: tuple[str, ...]) -> str:
    names = [name for part in columns for name in part if any(row.get(name) not in (None, "") for row in rows)]
    return table([name.replace("_", " ") for name in names], [[_cell(row.get(name)) for name in names] for row in rows])


def _cell(value: object) -> str:
    if value is None or value == "":
        return "-"
    return (
        f"{value:.3g}"
        if isinstance(value, float) and abs(value) < 10.0
        else (f"{value:.2f}" if isinstance(value, float) else str(value))
    )


if __name__ == "__main__":
    # Only here: every process that a measurement gets to itself imports this module.
    main()
