"""What a user may write who checks types strictly: from a configuration to the rows of a trajectory."""

from pathlib import Path

import numpy as np

from pipeline import (
    ConfigError,
    ExportOptions,
    Format,
    NoSolutionError,
    Trajectory,
    build_machine,
    build_regions,
    certify_path,
    condition_number,
    format_samples,
    inverse_kinematics,
    load_config,
    open_results,
    plan_route,
    refine_path,
    retime_path,
    sample_trajectory,
    statics_matrix,
)


def plan(file: Path) -> Trajectory | None:
    """Plan a motion; None if it is not proven free of singularities."""
    try:
        config = load_config(file)
    except ConfigError as error:
        raise SystemExit("\n".join(f"{issue.path}: {issue.message}" for issue in error.issues)) from None
    machine = build_machine(config.machine)
    try:
        route = plan_route(config, machine, build_regions(config, machine))
        refinement = refine_path(config, machine, route)
        certificate = certify_path(config, machine, refinement.path)
        return retime_path(config, refinement.path) if certificate.verdict == "certified" else None
    except NoSolutionError as error:
        raise SystemExit(f"{error.reason}: {error.advice}") from None


def kappa(file: Path) -> float:
    """Give the condition number at a pose."""
    machine = build_machine(load_config(file).machine)
    solution = inverse_kinematics(machine, np.array([[1.0, 0.3, 0.9, 0.0, 0.0]]), np.array([0]))
    return float(condition_number(statics_matrix(machine, solution.pose, solution.q_m[:, :3]))[0])


def table(run: Path) -> str:
    """Write the trajectory of a run as a table."""
    results = open_results(run)
    trajectory = results.trajectory
    samples = sample_trajectory(trajectory, 0.004)
    limits = np.ones(5)
    return format_samples(Format.CSV, samples, limits, ("a", "b", "c", "d", "e"), ExportOptions(decimals=12))
