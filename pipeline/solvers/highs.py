"""HiGHS: linear, convex quadratic and mixed-integer programs, and one vocabulary for how a solve ended."""

import errno
import os
from dataclasses import dataclass
from pathlib import Path

import highspy
import numpy as np
from scipy.sparse import csc_array

from pipeline.arrays import BoolArray, FloatArray
from pipeline.parallel import THREADS, processors
from pipeline.progress import QUIET, Monitor, Progress
from pipeline.status import Status

_STATUS = {
    highspy.HighsModelStatus.kOptimal: Status.OPTIMAL,
    highspy.HighsModelStatus.kInfeasible: Status.INFEASIBLE,
    highspy.HighsModelStatus.kTimeLimit: Status.TIME_LIMIT,
}


@dataclass(frozen=True, eq=False)
class LinearProgram:
    """Minimise cost . x + x . hessian x / 2 with low <= matrix x <= high, bounds on x, and some x integer.

    Attributes
    ----------
    matrix : (m, n) sparse, by columns
    cost : (n,)
    column_bounds, row_bounds : pair of (n,), pair of (m,)
        Least and largest; infinite where there is no limit.
    integer : (n,)
        Which unknowns are integers.
    hessian : (n, n) sparse, by columns, or None
        The lower triangle; without it the program is linear.
    """

    matrix: csc_array
    cost: FloatArray
    column_bounds: tuple[FloatArray, FloatArray]
    row_bounds: tuple[FloatArray, FloatArray]
    integer: BoolArray
    hessian: csc_array | None = None

    @property
    def columns(self) -> int:
        """Number of unknowns."""
        return int(self.matrix.shape[1])

    @property
    def rows(self) -> int:
        """Number of constraints."""
        return int(self.matrix.shape[0])


@dataclass(frozen=True, eq=False)
class Outcome:
    """Result of a solve; `values` is empty unless there is a feasible point."""

    status: Status
    values: FloatArray
    objective: float
    bound: float
    gap: float


def write_program(program: LinearProgram, target: Path) -> None:
    """Write a program as an MPS or LP file, by the ending of its name; columns are named c0, c1, ... in order.

    Raises
    ------
    OSError
        When the file cannot be written.
    """
    solver = highspy.Highs()
    solver.setOptionValue("output_flag", False)
    solver.passModel(_highs_model(program))
    # HiGHS crashes where it cannot open an LP file.
    if not target.parent.is_dir() or solver.writeModel(str(target)) == highspy.HighsStatus.kError:
        raise OSError(errno.EIO, "cannot be written", str(target))
    # HiGHS does not notice a full disk.
    if not _is_complete(target):
        raise OSError(errno.ENOSPC, "cannot be written to its end: no space left", str(target))


def _is_complete(target: Path) -> bool:
    """Check whether a file of a program has its last line."""
    with target.open("rb") as file:
        file.seek(max(0, file.seek(0, os.SEEK_END) - 16))
        return file.read().split()[-1:] in ([b"ENDATA"], [b"end"])


def solver_name() -> str:
    """Name and version of the solver."""
    return f"HiGHS {highspy.Highs().version()}"


def solve_program(
    program: LinearProgram, time_limit_s: float, monitor: Monitor = QUIET, relative_gap: float = 0.0
) -> Outcome:
    """Solve to a relative gap, by default of zero; Ctrl-C stops the solver and is raised again.

    Raises
    ------
    KeyboardInterrupt
        When the user interrupts.
    """
    solver = highspy.Highs()
    # Switching off all output would also switch off the progress reports.
    solver.setOptionValue("log_to_console", monitor.verbose)
    if THREADS in os.environ:
        solver.setOptionValue("threads", processors())
    solver.setOptionValue("mip_rel_gap", relative_gap)
    solver.setOptionValue("mip_abs_gap", 1e-7)
    solver.setOptionValue("primal_feasibility_tolerance", 1e-9)
    # The default, 1e-6, would let x and the cost be wrong by as much.
    solver.setOptionValue("mip_feasibility_tolerance", 1e-9)
    # The quadratic programs are definite between fixed ends; regularised they would miss by a micrometre.
    solver.setOptionValue("qp_regularization_value", 0.0)
    solver.setOptionValue("time_limit", time_limit_s)
    solver.passModel(_highs_model(program))
    solver.HandleUserInterrupt = True
    solver.cbMipLogging.subscribe(lambda event: report_incumbent(event.data_out, monitor.progress))
    solver.startSolve()
    try:
        while not solver.wait(0.1)[0]:
            pass
    except KeyboardInterrupt:
        solver.cancelSolve()
        while not solver.wait(0.1)[0]:
            pass
        raise
    return _outcome(solver)


def _highs_model(program: LinearProgram) -> highspy.HighsModel:
    """Copy a program into HiGHS' own structure."""
    model = highspy.HighsModel()
    lp, matrix = model.lp_, program.matrix
    lp.num_row_, lp.num_col_ = matrix.shape
    lp.col_cost_ = program.cost
    lp.col_lower_, lp.col_upper_ = program.column_bounds
    lp.row_lower_, lp.row_upper_ = program.row_bounds
    lp.a_matrix_.format_ = highspy.MatrixFormat.kColwise
    lp.a_matrix_.start_, lp.a_matrix_.index_, lp.a_matrix_.value_ = matrix.indptr, matrix.indices, matrix.data
    kinds = (highspy.HighsVarType.kContinuous, highspy.HighsVarType.kInteger)
    if program.integer.any():
        lp.integrality_ = [kinds[int(flag)] for flag in program.integer]
    if program.hessian is not None:
        model.hessian_.dim_ = program.columns
        model.hessian_.format_ = highspy.HessianFormat.kTriangular
        model.hessian_.start_, model.hessian_.index_ = program.hessian.indptr, program.hessian.indices
        model.hessian_.value_ = program.hessian.data
    return model


def _outcome(solver: highspy.Highs) -> Outcome:
    info = solver.getInfo()
    status = _STATUS.get(solver.getModelStatus(), Status.NOT_CONVERGED)
    feasible = info.primal_solution_status == highspy.SolutionStatus.kSolutionStatusFeasible
    values = np.array(solver.getSolution().col_value) if feasible else np.empty(0)
    is_mip = info.mip_node_count >= 0
    return Outcome(
        status=status,
        values=values,
        objective=info.objective_function_value if feasible else np.inf,
        bound=info.mip_dual_bound if is_mip else info.objective_function_value,
        gap=info.mip_gap if is_mip else 0.0,
    )


def report_incumbent(data: highspy.cb.HighsCallbackOutput, progress: Progress) -> None:
    """Report incumbent, bound and gap of a running solve; HiGHS gives infinities where there are none yet."""
    incumbent = f"{data.mip_primal_bound:.3f}" if np.isfinite(data.mip_primal_bound) else "none yet"
    gap = f", gap {data.mip_gap:.2%}" if np.isfinite(data.mip_gap) else ""
    progress(f"HiGHS: incumbent {incumbent}, bound {data.mip_dual_bound:.3f}{gap}")
