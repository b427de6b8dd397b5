"""The compact program in SCIP, read from its MPS file."""

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyscipopt

from tests.benchmarks.isolated import peak_mb
from tests.benchmarks.peers.reading import PROGRAM, read_sequence

_STATUS = {"optimal": "optimal", "infeasible": "infeasible", "timelimit": "time limit"}


def compact(folder: Path, limit_s: float) -> Iterator[dict[str, Any]]:
    """Solve the compact program to a gap of zero, SCIP's default."""
    model = pyscipopt.Model()
    model.hideOutput()
    begin = time.perf_counter()
    model.readProblem(str(folder / PROGRAM))
    built = time.perf_counter()
    told = {"build_s": built - begin, "solver": f"SCIP {model.version()}"}
    yield told
    model.setParam("limits/time", limit_s)
    model.optimize()
    status = model.getStatus()
    told |= {"seconds": time.perf_counter() - built, "status": _STATUS.get(status, status), "peak_mb": peak_mb()}
    told["bound"] = model.getDualbound()
    if model.getNSols():
        best = model.getBestSol()
        values = np.empty(model.getNVars(transformed=False))
        for variable in model.getVars(transformed=False):
            values[int(variable.name[1:])] = best[variable]
        told["rows"], told["x_m"] = read_sequence(folder, values)
    yield told
