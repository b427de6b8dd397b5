"""The least integral of kappa on a mesh: the program built and solved, roughly first."""

from dataclasses import replace

from scipy.interpolate import BSpline

from pipeline.errors import NoSolutionError
from pipeline.machine.samples import PoseSamples
from pipeline.refine.collocation.data import node_data
from pipeline.refine.collocation.ipopt import IpoptOptions, ipopt_failure, solve_program
from pipeline.refine.corridor.cells import corridor
from pipeline.refine.integral.program import InitialGuess, ProgramData, build_program
from pipeline.refine.problem import FROBENIUS, SCHATTEN, MeshSolution, Problem, first_mesh, transfer_to
from pipeline.refine.result import Path
from pipeline.refine.splines import DEGREE
from pipeline.solvers import interrupts_noted

_EVENNESS_FIRST, _EVENNESS = 10.0, 0.1
"""Cost of uneven speed along s, in units of kappa: much at first, in the end what no figure notices."""
_ROUGH_ITERATIONS = 150
"""Most iterations of the rough solve: where IPOPT needs more it is lost, and the fallback start is faster."""
_FEW_NODES, _FEW_ITERATIONS = 0.7, 60
"""Share of the nodes that the rough solve takes, and most of its iterations with that many."""


def minimise_integral(problem: Problem, initial: MeshSolution) -> MeshSolution:
    """Minimise the integral of kappa on the first mesh: roughly, then precisely.

    Raises
    ------
    NoSolutionError
        If IPOPT does not converge; its last path is in the `diagnosis`.
    """
    most, time_limit_s = problem.config.refine.max_iterations, problem.config.refine.time_limit_s
    near = _near_minimum(problem, initial)
    return solve_on_mesh(problem, near, SCHATTEN, _EVENNESS, IpoptOptions(most, time_limit_s, "precise"))


def _near_minimum(problem: Problem, initial: MeshSolution) -> MeshSolution:
    """Minimise the integral of the Frobenius kappa roughly, at even speed: on fewer nodes, or if that fails on all."""
    most, time_limit_s = problem.config.refine.max_iterations, problem.config.refine.time_limit_s
    few = transfer_to(initial, replace(initial.mesh, s=first_mesh(problem, _FEW_NODES).s))
    try:
        options = IpoptOptions(min(most, _FEW_ITERATIONS), time_limit_s, "rough")
        near = solve_on_mesh(problem, few, FROBENIUS, _EVENNESS_FIRST, options)
        return transfer_to(near, initial.mesh)
    except NoSolutionError as failure:
        problem.monitor.progress(f"refine: {failure.reason}; trying with more nodes")
    options = IpoptOptions(min(most, _ROUGH_ITERATIONS), time_limit_s, "rough")
    return solve_on_mesh(problem, initial, FROBENIUS, _EVENNESS_FIRST, options)


def solve_on_mesh(
    problem: Problem, initial: MeshSolution, exponent: float, evenness: float, options: IpoptOptions
) -> MeshSolution:
    """Build and solve the program of a mesh, starting from a path that is known at its nodes.

    Raises
    ------
    NoSolutionError
        If IPOPT does not converge; its last path is in the `diagnosis`.
    """
    mesh = initial.mesh
    label = f"refine: {len(mesh.s)} nodes, {mesh.coefficients} coefficients"
    problem.monitor.progress(f"{label}: building the program")
    # CasADi swallows errors raised while it converts arguments, and Ctrl-C is one.
    with interrupts_noted():
        program = build_program(program_data(problem, initial, exponent, evenness), guess_from(initial))
    result = solve_program(program, options, label, problem.monitor)
    spline = BSpline(mesh.knots, program.spline_coefficients(result.x), DEGREE)
    path = Path(problem.machine, spline, mesh.s, program.poses(result.x))
    integral = float(program.integral(result.x))
    solution = MeshSolution(mesh, path, integral, initial.iterations + result.iterations)
    if not result.status.solved:
        raise ipopt_failure(result, solution.arrays)
    return solution


def program_data(problem: Problem, initial: MeshSolution, exponent: float, evenness: float) -> ProgramData:
    """Collect what the program of a mesh is written for."""
    mesh = initial.mesh
    bounds = corridor(problem.config, problem.route, problem.coarse, mesh.s)
    return ProgramData(node_data(problem, mesh, bounds), exponent, evenness, problem.smoothness.form(mesh.knots))


def guess_from(initial: MeshSolution) -> InitialGuess:
    """Take poses, actuators and coefficients of a path as initial guess."""
    path = initial.path
    return InitialGuess(PoseSamples(path.machine, path.node_pose, path.q(initial.mesh.s)), path.spline.c)
