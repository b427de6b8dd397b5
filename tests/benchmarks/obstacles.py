"""Random obstacles around the reference machine with bodies: what comes of such tasks, and whether it is so.

Answers are checked by another library, coal, where it is installed.
"""

import copy
import importlib.util
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeline.certify import Certificate, certify_path
from pipeline.certify.recheck import verify
from pipeline.config import Config
from pipeline.config.file import load_config, parse_config
from pipeline.errors import ConfigError, InfeasibleError, NoSolutionError
from pipeline.limits.bodies.obstacle_distance import relaxations
from pipeline.limits.bodies.pairs import kept_apart
from pipeline.machine import Machine, build_machine, inverse_kinematics
from pipeline.machine.geometry import MODES
from pipeline.machine.samples import PoseSamples
from pipeline.refine import Path, refine_path
from pipeline.route import RegionTable, build_regions, plan_route
from pipeline.route.diagnosis.search import explain_infeasibility
from pipeline.route.regions.endpoints import task_endpoints
from tests.benchmarks.problems import CONFIGS, Problem
from tests.certify.paths import state
from tests.machine.bodies.coal_oracle import CoalOracle

SAMPLES = 100_000
HAS_COAL = importlib.util.find_spec("coal") is not None
_LOW, _HIGH = [0.3, -0.3, 0.1], [1.8, 1.0, 1.4]
"""Where centres of obstacles are drawn."""
_MOST = 3
"""Obstacles of a task."""


@dataclass(frozen=True)
class Refused:
    """A drawn task whose start or goal is refused: why, and the distance of the nearest pair there by coal."""

    problem: Problem
    reason: str
    nearest_m: float | None


def obstacle_tasks(count: int, seed: int = 7) -> Iterator[Problem | Refused]:
    """Draw tasks with one to three obstacles until `count` of them can start and end; also those that cannot.

    Every other task is the reference task; the others go from one random pose and mode to another.
    """
    quick, base = (
        load_config(CONFIGS / "quick.yaml"),
        load_config(CONFIGS / "agder-bodies.yaml").model_dump(mode="json"),
    )
    base["route"] = quick.route.model_dump(mode="json")
    rng, found = np.random.default_rng(seed), 0
    while found < count:
        document = copy.deepcopy(base)
        if found % 2:
            document["task"] |= _random_ends(base, rng)
        document["task"]["obstacles"] = [_obstacle(rng, number) for number in range(rng.integers(1, _MOST + 1))]
        document["name"] = f"obstacles-{found + 1}"
        config = parse_config(document)
        problem = Problem(_words(config), config)
        try:
            task_endpoints(config, build_machine(config.machine))
        except ConfigError as error:
            issue = error.issues[0]
            yield Refused(problem, str(issue), _nearest_at(config, issue.path.rpartition(".")[2]))
            continue
        found += 1
        yield problem


def _obstacle(rng: np.random.Generator, number: int) -> dict[str, Any]:
    """Draw a box, a bar or a stone."""
    name, centre = f"obstacle{number + 1}", rng.uniform(_LOW, _HIGH)
    kind = rng.integers(3)
    if kind == 0:
        return {"name": name, "box": {"centre_m": _rounded(centre), "size_m": _rounded(rng.uniform(0.05, 0.35, 3))}}
    if kind == 1:
        along = rng.normal(size=3) * 0.3
        ends = {"from_m": _rounded(centre - along), "to_m": _rounded(centre + along)}
        return {"name": name, "capsule": {**ends, "radius_m": round(float(rng.uniform(0.01, 0.05)), 3)}}
    points = [_rounded(point) for point in centre + rng.normal(size=(6, 3)) * 0.1]
    return {"name": name, "hull": {"points_m": points, "radius_m": 0.01}}


def _rounded(values: np.ndarray) -> list[float]:
    return [round(float(value), 3) for value in values]


def _random_ends(base: dict[str, Any], rng: np.random.Generator) -> dict[str, Any]:
    """Draw start and goal that are admitted without obstacles."""
    document = copy.deepcopy(base)
    while True:
        for end in ("start", "goal"):
            document["task"][end] = {
                "x_m": round(rng.uniform(0.6, 1.5), 3),
                "y_m": round(rng.uniform(0.1, 0.8), 3),
                "z_m": round(rng.uniform(0.5, 1.1), 3),
                "rx_deg": round(rng.uniform(-10.0, 10.0), 1),
                "rz_deg": round(rng.uniform(-10.0, 10.0), 1),
                "mode": MODES[rng.integers(8)],
            }
        config = parse_config(document)
        try:
            task_endpoints(config, build_machine(config.machine))
        except (ConfigError, NoSolutionError):
            continue
        return {end: document["task"][end] for end in ("start", "goal")}


def _nearest_at(config: Config, end: str) -> float | None:
    """Measure the nearest pair at an end by coal."""
    machine = build_machine(config.machine)
    asked = getattr(config.task, end)
    controlled = np.array([[asked.x_m, asked.y_m, asked.z_m, *np.deg2rad([asked.rx_deg, asked.rz_deg])]])
    solution = inverse_kinematics(machine, controlled, np.array([MODES.index(asked.mode)]))
    return nearest_by_coal(config, machine, PoseSamples(machine, solution.pose, solution.q_m))


def nearest_by_coal(config: Config, machine: Machine, samples: PoseSamples) -> float | None:
    """Measure all pairs at one pose, and give the distance of the nearest; None without coal."""
    if not HAS_COAL:
        return None
    oracles = [CoalOracle(bodies, samples) for bodies in kept_apart(config, machine)]
    return min(oracle.distance(pair, 0) for oracle in oracles for pair in range(len(oracle.bodies.pairs)))


def measure_task(config: Config) -> Iterator[dict[str, Any]]:
    """Plan, refine and certify a task, verify the certificate, and look for collisions of the path by coal."""
    machine, began = build_machine(config.machine), time.perf_counter()
    try:
        regions = build_regions(config, machine)
        yield {"regions": len(regions), "regions_s": time.perf_counter() - began}
        route = plan_route(config, machine, regions)
        yield {
            "route_s": time.perf_counter() - began,
            "objective": route.objective,
            "modes": " ".join(route.mode_names),
        }
        path = refine_path(config, machine, route).path
        yield {"refine_s": time.perf_counter() - began}
        certificate = certify_path(config, machine, path)
    except InfeasibleError as error:
        yield {"outcome": "no route, proven", "reason": error.reason, "seconds": time.perf_counter() - began}
        yield {"opens": _what_opens(config, machine, regions)}
        return
    except NoSolutionError as error:
        yield {"outcome": f"no {error.stage}", "reason": error.reason, "seconds": time.perf_counter() - began}
        return
    yield {"outcome": "certified", "boxes": len(certificate.chain.boxes), "seconds": time.perf_counter() - began}
    yield check_certified(config, machine, path, certificate)


def _what_opens(config: Config, machine: Machine, regions: RegionTable) -> list[str]:
    """Say what comes of leaving out obstacles: where they are the reason, a route is found."""
    report = explain_infeasibility(config, machine, regions, limits=relaxations(config, machine))
    return [finding.sentence for finding in report.findings]


def check_certified(config: Config, machine: Machine, path: Path, certificate: Certificate) -> dict[str, Any]:
    """Verify a certificate again, and compare proven distances with coal's at `SAMPLES` poses of the path."""
    claims = verify(config, machine, path, task_endpoints(config, machine), state(certificate))
    found: dict[str, Any] = {"refused_claims": [claim.what for claim in claims if not claim.verified]}
    if not HAS_COAL:
        return {**found, "coal": "skipped: coal is not installed"}
    assert certificate.bounds is not None
    proven = dict(
        pair
        for ranges in certificate.bounds.ranges.values()
        for pair in zip(ranges.subjects, ranges.values[:, 0].tolist(), strict=True)
    )
    s = np.linspace(0.0, 1.0, SAMPLES)
    samples = PoseSamples(machine, path.pose(s), path.q(s))
    below, nearest, asked, pairs = [], np.inf, 0, 0
    for bodies in kept_apart(config, machine):
        oracle = CoalOracle(bodies, samples)
        for pair, name in enumerate(bodies.names):
            least = oracle.least(pair, max(proven[name], bodies.clearance_m))
            nearest = min(nearest, least)
            if least < max(proven[name], bodies.clearance_m):
                below.append(f"{name}: {1e3 * least:.3f} mm, proven {1e3 * proven[name]:.3f} mm")
        asked, pairs = asked + oracle.asked, pairs + len(bodies.pairs)
    least_proven = min(proven[name] for bodies in kept_apart(config, machine) for name in bodies.names)
    return {
        **found,
        "proven_m": least_proven,
        "nearest_m": nearest,
        "below": below,
        "asked": asked,
        "pairs": pairs,
    }


def _words(config: Config) -> str:
    """Name the ends of a task, and what is in its way."""
    ends = (config.task.start, config.task.goal)
    shapes = [next(name for name in ("box", "capsule", "hull") if getattr(one, name)) for one in config.task.obstacles]
    return " to ".join(f"{end.mode} ({end.x_m:g}, {end.y_m:g}, {end.z_m:g})" for end in ends) + f"; {', '.join(shapes)}"
