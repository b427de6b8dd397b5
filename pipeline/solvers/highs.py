"""Running HiGHS: options, progress, interruption, and one vocabulary for how it ended."""

from dataclasses import dataclass
from pathlib import Path

import highspy
import numpy as np
from scipy.sparse import csc_array, csr_array

from pipeline.arrays import BoolArray, FloatArray
from pipeline.progress import Progress
from pipeline.status import Status

_STATUS = {
    highspy.HighsModelStatus.kOptimal: Status.OPTIMAL,
    highspy.HighsModelStatus.kInfeasible: Status.INFEASIBLE,
    highspy.HighsModelStatus.kTimeLimit: Status.TIME_LIMIT,
}


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a solve gave; `values` is empty unless there is a feasible point."""

    status: Status
    values: FloatArray
    objective: float
    bound: float
    gap: float


def make_model(
    matrix: csc_array | csr_array,
    cost: FloatArray,
    column_bounds: tuple[FloatArray, FloatArray],
    row_bounds: tuple[FloatArray, FloatArray],
    integer: BoolArray,
) -> highspy.HighsModel:
    """Fill HiGHS' own structure: minimise cost . x with low <= matrix x <= high, bounds and integrality of x."""
    model = highspy.HighsModel()
    lp, columns = model.lp_, csc_array(matrix)
    lp.num_row_, lp.num_col_ = columns.shape
    lp.col_cost_ = cost
    lp.col_lower_, lp.col_upper_ = column_bounds
    lp.row_lower_, lp.row_upper_ = row_bounds
    lp.a_matrix_.format_ = highspy.MatrixFormat.kColwise
    lp.a_matrix_.start_, lp.a_matrix_.index_, lp.a_matrix_.value_ = columns.indptr, columns.indices, columns.data
    kinds = (highspy.HighsVarType.kContinuous, highspy.HighsVarType.kInteger)
    if integer.any():
        lp.integrality_ = [kinds[int(flag)] for flag in integer]
    return model


def write_model(model: highspy.HighsModel, target: Path) -> None:
    """Write a program as an MPS or LP file, by the ending of its name.

    Raises
    ------
    OSError
        When the file cannot be written.
    """
    solver = highspy.Highs()
    solver.setOptionValue("output_flag", False)
    solver.passModel(model)
    if solver.writeModel(str(target)) == highspy.HighsStatus.kError:
        raise OSError(f"{target} cannot be written")


def solver_name() -> str:
    """Name and version of the solver."""
    return f"HiGHS {highspy.Highs().version()}"


def solve_model(model: highspy.HighsModel, time_limit_s: float, progress: Progress, verbose: bool = False) -> Outcome:
    """Solve to a gap of zero; Ctrl-C stops the solver and is raised again.

    Raises
    ------
    KeyboardInterrupt
        When the user interrupts.
    """
    solver = highspy.Highs()
    # Without any output there would be no progress to report either.
    solver.setOptionValue("log_to_console", verbose)
    solver.setOptionValue("mip_rel_gap", 0.0)
    solver.setOptionValue("mip_abs_gap", 1e-7)
    solver.setOptionValue("primal_feasibility_tolerance", 1e-9)
    # The default, 1e-6, would let x and the cost be wrong by as much.
    solver.setOptionValue("mip_feasibility_tolerance", 1e-9)
    # The quadratic programs are definite between fixed ends; regularised they would miss by a micrometre.
    solver.setOptionValue("qp_regularization_value", 0.0)
    solver.setOptionValue("time_limit", time_limit_s)
    solver.passModel(model)
    solver.HandleUserInterrupt = True
    solver.cbMipLogging.subscribe(lambda event: _report(event.data_out, progress))
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


def _report(data: highspy.cb.HighsCallbackOutput, progress: Progress) -> None:
    incumbent = f"{data.mip_primal_bound:.3f}" if np.isfinite(data.mip_primal_bound) else "none yet"
    gap = f", gap {data.mip_gap:.2%}" if np.isfinite(data.mip_gap) else ""
    progress(f"HiGHS: incumbent {incumbent}, bound {data.mip_dual_bound:.3f}{gap}")
