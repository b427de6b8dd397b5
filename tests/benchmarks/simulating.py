"""The twin measured: speed, ideal drives, MuJoCo, stiffness against gravity, random machines; `make bench-simulate`."""

import time
from collections.abc import Iterator
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from pipeline.artifacts import json_bytes, write_whole
from pipeline.config import Config
from pipeline.errors import NoSolutionError
from pipeline.machine import Machine, build_machine
from pipeline.machine.actuator_space import actuator_rates, gravity_stiffness
from pipeline.refine import refine_path
from pipeline.retime import Trajectory, retime_path, way_back
from pipeline.route import build_regions, plan_route
from pipeline.run import open_results
from pipeline.simulate import (
    Deviations,
    Drives,
    Motion,
    Simulation,
    build_drives,
    build_plant,
    ideal_drives,
    plan_motion,
    simulate_motion,
)
from pipeline.simulate.tuning import tune_drives
from tests.benchmarks.host import describe_host
from tests.benchmarks.isolated import FINISHED, measure
from tests.benchmarks.report import table
from tests.benchmarks.variety import random_machines, random_tasks
from tests.simulate.motions import standing
from tests.simulate.mujoco_twin import follow_in_mujoco

_OUT = Path(__file__).parents[2] / "results" / "benchmarks"
_PERIOD_S = 1e-3
_STANDS_S = 8.0


def main() -> None:
    """Run the command line."""
    typer.run(benchmark)


def benchmark(
    run: Annotated[Path, typer.Argument(help="a run of the reference machine")] = Path("results/agder"),
    out: Annotated[Path, typer.Option(help="folder for simulate.json and simulate.md")] = _OUT,
    machines: Annotated[int, typer.Option(min=0, help="random machines")] = 12,
    tasks: Annotated[int, typer.Option(min=0, help="random tasks")] = 13,
    limit_s: Annotated[float, typer.Option(min=1.0, help="time limit of each random run")] = 900.0,
) -> None:
    """Measure the twin on a run, and on random machines and tasks."""
    found: dict[str, Any] = {"host": describe_host(), **measure_twin(run)}
    typer.echo(json_bytes(found).decode())
    found["random"] = []
    for problem in chain(random_machines(machines), random_tasks(tasks)):
        done = measure("tests.benchmarks.simulating:measure_problem", (problem.config,), limit_s)
        row = {"problem": problem.name, **done.figures}
        found["random"].append(row if done.ended == FINISHED else {**row, "outcome": done.ended})
        typer.echo(found["random"][-1])
    write_whole(out / "simulate.json", json_bytes(found))
    write_whole(out / "simulate.md", markdown(found).encode())


def measure_twin(run: Path) -> dict[str, Any]:
    """Measure speed, ideal drives, the difference to MuJoCo, scenarios, and the least stiffness that holds."""
    results = open_results(run)
    machine, there = results.machine, results.trajectory
    drives = build_drives(results.config.drives, machine)
    ways = {"there": there, "back": way_back(results.config, there)}
    motions = {name: plan_motion(trajectory, _PERIOD_S) for name, trajectory in ways.items()}
    return {
        "ideal": {name: _ideal(machine, drives, motion) for name, motion in motions.items()},
        "mujoco": {name: _beside_mujoco(machine, drives, motion) for name, motion in motions.items()},
        "scenarios": list(_scenarios(machine, drives, motions["there"])),
        "stiffness": stiffness_that_holds(machine, drives, motions["there"]),
    }


def _simulated(machine: Machine, drives: Drives, motion: Motion, deviations: Deviations | None = None) -> Simulation:
    return simulate_motion(machine, build_plant(machine, deviations or Deviations()), drives, motion)


def _ideal(machine: Machine, drives: Drives, motion: Motion) -> dict[str, float]:
    before = time.process_time()
    simulation = _simulated(machine, ideal_drives(drives), motion)
    return {
        "tcp_mm": 1e3 * _tcp(simulation),
        "cpu_s": time.process_time() - before,
        "simulated_per_cpu_second": simulation.simulated_s / (time.process_time() - before),
    }


def _beside_mujoco(machine: Machine, drives: Drives, motion: Motion) -> dict[str, float]:
    """Compare with MuJoCo: a machine 5 % too heavy with motors and friction, without encoders' steps and integrals."""
    exact = replace(drives, encoder_step_m=np.zeros(5), integral_gain_npm=np.zeros(5))
    plant = build_plant(machine, Deviations(mass_error=0.05))
    figures = {}
    for name, one in (("viscous", replace(exact, dry_friction_n=np.zeros(5))), ("dry", exact)):
        simulation = simulate_motion(machine, plant, one, motion, standing_s=0.0)
        _, xyz = follow_in_mujoco(plant.machine, one, motion)
        figures[f"{name}_difference_um"] = 1e6 * float(np.linalg.norm(simulation.pose[:, :3] - xyz, axis=1).max())
        figures[f"{name}_error_mm"] = 1e3 * _tcp(simulation)
    return figures


def _scenarios(machine: Machine, drives: Drives, motion: Motion) -> Iterator[dict[str, Any]]:
    tuned = tune_drives(machine, drives, motion, 0.2).drives
    without_velocity = replace(drives, velocity_forward=np.array([1.0, 1.0, 1.0, 0.0, 0.0]))
    for name, one, deviations in (
        ("assumed drives", drives, Deviations()),
        ("friction fed forward", replace(drives, friction_forward=np.ones(5)), Deviations()),
        ("tuned", tuned, Deviations()),
        ("masses 5 % larger", drives, Deviations(mass_error=0.05)),
        ("load of 5 kg", drives, Deviations(load_kg=5.0)),
        ("geometry 0.2 mm off, ideal drives", ideal_drives(drives), Deviations(2e-4)),
        ("geometry 0.2 mm off", drives, Deviations(2e-4)),
        ("geometry 0.2 mm off, tuned", tuned, Deviations(2e-4)),
        ("telescopes without velocity fed forward", without_velocity, Deviations()),
    ):
        simulation = _simulated(machine, one, motion, deviations)
        yield {
            "scenario": name,
            "ending": str(simulation.verdict.ending),
            "tcp_mm": 1e3 * _tcp(simulation),
            "following_mm": (1e3 * np.abs(simulation.following_error_m).max(axis=0)).round(3).tolist(),
            "simulated_per_second": simulation.simulated_s / simulation.seconds,
        }


def stiffness_that_holds(machine: Machine, drives: Drives, motion: Motion) -> dict[str, float]:
    """Find where gravity is most against a motion, and the least stiffness of telescopes that holds the machine there.

    It stands with exact forces fed forward and a push of 1 N; held is what is within 5 mm after 8 s.
    """
    K = gravity_stiffness(machine, actuator_rates(machine, motion.pose, motion.q_m[:, :3]))
    values, vectors = np.linalg.eigh(K)
    row = int(values[:, 0].argmin())
    push = vectors[row, :, 0] * (np.arange(5) >= 3)
    still = standing(machine, motion.q_m[row], motion.pose[row], _STANDS_S)
    pushed = replace(still, middle_n=still.middle_n + push / np.linalg.norm(push))
    kv = np.array([8_000.0] * 3 + [300.0] * 2)
    held = {}
    for stiffness in np.arange(1_000.0, 20_001.0, 1_000.0):
        gains = {"velocity_gain_nspm": kv, "position_gain_per_s": np.where(np.arange(5) < 3, 10.0, stiffness / kv)}
        weak = replace(ideal_drives(drives), **gains, integral_gain_npm=np.zeros(5), trip_m=np.ones(5))
        simulation = simulate_motion(machine, build_plant(machine, Deviations()), weak, pushed, standing_s=0.0)
        off = np.abs(simulation.following_error_m[-1]).max() if simulation.verdict.arrived else np.inf
        held[stiffness] = bool(off < 5e-3)
    return {
        "t_s": float(motion.t_s[row]),
        "gravity_npm": float(values[row, 0]),
        "largest_that_fails_npm": max(value for value, holds in held.items() if not holds),
        "least_that_holds_npm": min(value for value, holds in held.items() if holds),
    }


def measure_problem(config: Config) -> Iterator[dict[str, Any]]:
    """Plan a motion, and simulate it there and back with the drives that are assumed and with tuned ones."""
    machine = build_machine(config.machine)
    try:
        route = plan_route(config, machine, build_regions(config, machine))
        trajectory: Trajectory = retime_path(config, refine_path(config, machine, route).path)
    except NoSolutionError as error:
        yield {"outcome": f"no {error.stage}"}
        return
    drives = build_drives(config.drives, machine)
    there = plan_motion(trajectory, _PERIOD_S)
    tuning = tune_drives(machine, drives, there, 0.1)
    yield {
        "damping_assumed": float(tuning.before.damping.min()),
        "damping_tuned": float(tuning.after.damping.min()),
        "gains": tuning.gains._asdict(),
    }
    for way, motion in (("there", there), ("back", plan_motion(way_back(config, trajectory), _PERIOD_S))):
        for name, one in (("assumed", drives), ("tuned", tuning.drives)):
            simulation = _simulated(machine, one, motion)
            yield {f"{name}_{way}": str(simulation.verdict.ending), f"{name}_{way}_tcp_mm": 1e3 * _tcp(simulation)}
    yield {"outcome": "simulated"}


def _tcp(simulation: Simulation) -> float:
    return float(np.linalg.norm(simulation.pose_error[:, :3], axis=1).max())


def markdown(found: dict[str, Any]) -> str:
    """Write everything as a page."""
    host = found["host"]
    scenarios = [(row["scenario"], row["ending"], f"{row['tcp_mm']:.3f}") for row in found["scenarios"]]
    keys = ("damping_assumed", "damping_tuned", "assumed_there_tcp_mm", "tuned_there_tcp_mm")
    rows = [
        (
            row["problem"],
            str(row.get("outcome", "-")),
            *(f"{row[key]:.3f}" if key in row else "-" for key in keys),
            *(str(row.get(f"{name}_{way}", "-")) for name in ("assumed", "tuned") for way in ("there", "back")),
        )
        for row in found["random"]
    ]
    stiffness = found["stiffness"]
    sections = [
        "# The twin",
        "Written by `make bench-simulate`; every number is in `simulate.json`. "
        f"On {host['cpu']}, {host['cores']} cores, {host['date']}.",
        "Ideal drives: "
        + "; ".join(
            f"{way} within {1e3 * row['tcp_mm']:.2f} um at the TCP, "
            f"{row['simulated_per_cpu_second']:.1f} s simulated per CPU second, all included"
            for way, row in found["ideal"].items()
        )
        + ".",
        "MuJoCo, same controllers, masses 5 % larger: "
        + "; ".join(
            f"{way} {row['viscous_difference_um']:.2f} um apart where both are {row['viscous_error_mm']:.2f} mm off, "
            f"with dry friction {row['dry_difference_um']:.2f} um of {row['dry_error_mm']:.2f} mm"
            for way, row in found["mujoco"].items()
        )
        + ".",
        f"Gravity is most against the motion at {stiffness['t_s']:.3f} s, {stiffness['gravity_npm']:.0f} N/m: "
        f"telescopes of {stiffness['least_that_holds_npm']:.0f} N/m hold the machine there, "
        f"of {stiffness['largest_that_fails_npm']:.0f} do not.",
        table(("scenario", "ending", "TCP mm"), scenarios),
        table(("problem", "outcome", *keys, "assumed there", "back", "tuned there", "back"), rows),
    ]
    return "\n\n".join(sections) + "\n"


if __name__ == "__main__":
    # Only here: every process that a measurement gets to itself imports this module.
    main()
