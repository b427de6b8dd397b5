"""Second derivatives of the Lagrangian, those of kappa computed once per node.

Left to itself CasADi differentiates the Lagrangian once for each colour of its Hessian, some twenty times, and
goes through kappa, by far the longest expression, every time. Here the kappa of a node is replaced by its
expansion of second order about the very point asked for: it has the same derivatives there, and costs next to nothing.
"""

from collections.abc import Callable

import casadi as ca


def lagrangian_hessian(
    kappa: ca.Function, pose: ca.MX, q: ca.MX, x: ca.MX, program: Callable[[ca.MX], tuple[ca.MX, ca.MX]]
) -> ca.Function:
    """Build (x, p, lam_f, lam_g) -> the upper triangle of the Hessian of lam_f f + lam_g . g, exactly.

    Parameters
    ----------
    kappa : Function
        (pose, q) -> kappa of a node.
    pose, q : (6, k), (5, k)
        The unknowns of the nodes.
    x : (n,)
        All unknowns.
    program : callable
        Writes the objective f and the constraints g (m,) with given kappa of the nodes (1, k).
    """
    k = pose.shape[1]
    derivatives = _derivatives(kappa)
    value = ca.MX.sym("value", 1, k)
    g = ca.MX.sym("g", ca.repmat(derivatives.sparsity_out("g"), 1, k))
    # The nonzeros of blocks side by side and of blocks along the diagonal come in the same order.
    blocks = ca.diagcat(*[derivatives.sparsity_out("H")] * k)
    H = ca.MX.sym("H", blocks)
    nodes, about = ca.vertcat(pose, q), ca.MX.sym("about", 11, k)
    step = nodes - about
    curvature = ca.reshape(H @ ca.vec(step), 11, k)
    f, constraints = program(value + ca.sum1((g + curvature / 2.0) * step))
    lam_f, lam_g, p = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", constraints.numel()), ca.MX.sym("p", 0)
    triangle = ca.triu(ca.hessian(lam_f * f + ca.dot(lam_g, constraints), x)[0])
    hessian = ca.Function("expanded", [x, about, value, g, H, lam_f, lam_g], [triangle])
    values, gradients, hessians = derivatives.map(k)(pose, q)
    result = hessian(x, nodes, values, gradients, ca.sparsity_cast(hessians, blocks), lam_f, lam_g)
    return ca.Function("hessian", [x, p, lam_f, lam_g], [result], ["x", "p", "lam_f", "lam_g"], ["triu_hess_gamma_x_x"])


def _derivatives(kappa: ca.Function) -> ca.Function:
    """Build (pose, q) -> kappa, its gradient (11,) and its Hessian (11, 11)."""
    pose, q = ca.SX.sym("pose", 6), ca.SX.sym("q", 5)
    value = kappa(pose, q)
    H, g = ca.hessian(value, ca.vertcat(pose, q))
    return ca.Function("derivatives", [pose, q], [value, g, H], ["pose", "q"], ["value", "g", "H"])
