"""The compact program in CBC, as OR-Tools brings it along, read from its MPS file."""

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from ortools.linear_solver import pywraplp
from ortools.linear_solver.python import model_builder

from tests.benchmarks.isolated import peak_mb
from tests.benchmarks.peers.reading import PROGRAM, read_sequence

_STATUS = {pywraplp.Solver.OPTIMAL: "optimal", pywraplp.Solver.INFEASIBLE: "infeasible"}


def compact(folder: Path, limit_s: float) -> Iterator[dict[str, Any]]:
    """Solve the compact program to a gap of zero."""
    solver = pywraplp.Solver.CreateSolver("CBC")
    if solver is None:
        yield {"status": "this OR-Tools has no CBC"}
        return
    begin = time.perf_counter()
    program = model_builder.Model()
    program.import_from_mps_file(str(folder / PROGRAM))
    solver.LoadModelFromProtoWithUniqueNamesOrDie(program.export_to_proto())
    built = time.perf_counter()
    told = {"build_s": built - begin, "solver": solver.SolverVersion()}
    yield told
    solver.SetTimeLimit(round(1000 * limit_s))
    parameters = pywraplp.MPSolverParameters()
    parameters.SetDoubleParam(parameters.RELATIVE_MIP_GAP, 0.0)
    status = solver.Solve(parameters)
    told |= {"seconds": time.perf_counter() - built, "status": _STATUS.get(status, "time limit"), "peak_mb": peak_mb()}
    told["bound"] = solver.Objective().BestBound()
    if status in (pywraplp.Solver.OPTIMAL, pywraplp.Solver.FEASIBLE):
        values = np.array([variable.solution_value() for variable in solver.variables()])
        told["rows"], told["x_m"] = read_sequence(folder, values)
    yield told
