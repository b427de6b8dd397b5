"""First and second derivatives of the program, with those of kappa given instead of derived.

In objective and constraints, the kappa of a node is replaced by its expansion about the point of evaluation, which has
the same derivatives there and costs next to nothing.
"""

from collections.abc import Callable

import casadi as ca

from pipeline.refine.collocation.node_kappa import UNKNOWNS, NodeKappa

Written = Callable[[ca.MX], tuple[ca.MX, ca.MX]]
"""Writes objective and constraints (m,) with given kappa of the nodes (1, k)."""


def derivative_options(kappa: NodeKappa, nodes: ca.MX, x: ca.MX, written: Written) -> dict[str, ca.Function]:
    """Build the options grad_f, jac_g and hess_lag, which CasADi's solvers use instead of differentiating.

    `nodes` (9, k) are pose and carts of every node as expressions of all unknowns x (n,); the Hessian is the upper
    triangle of that of lam_f f + lam_g . g.
    """
    k = nodes.shape[1]
    about, value, slope = ca.MX.sym("about", UNKNOWNS, k), ca.MX.sym("value", 1, k), ca.MX.sym("slope", UNKNOWNS, k)
    step = nodes - about
    given, p = kappa(nodes), ca.MX.sym("p", 0)
    f, g = written(value + ca.sum1(slope * step))
    known, here = [x, about, value, slope], [x, nodes, given[0], given[1]]
    gradient = ca.Function("expanded_gradient", known, [f, ca.densify(ca.gradient(f, x))])(*here)
    jacobian = ca.Function("expanded_jacobian", known, [g, ca.jacobian(g, x)])(*here)
    lam_f, lam_g = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", g.numel())
    # The nonzeros of blocks side by side and of blocks along the diagonal come in the same order.
    blocks = ca.diagcat(*[ca.Sparsity.dense(UNKNOWNS, UNKNOWNS)] * k)
    bend = ca.MX.sym("bend", blocks)
    curvature = ca.reshape(bend @ ca.vec(step), UNKNOWNS, k)
    f, g = written(value + ca.sum1((slope + curvature / 2.0) * step))
    triangle = ca.triu(ca.hessian(lam_f * f + ca.dot(lam_g, g), x)[0])
    expanded = ca.Function("expanded_hessian", [*known, bend, lam_f, lam_g], [triangle])
    hessian = expanded(*here, ca.sparsity_cast(given[2], blocks), lam_f, lam_g)
    return {
        "grad_f": ca.Function("gradient", [x, p], list(gradient), ["x", "p"], ["f", "grad_f_x"]),
        "jac_g": ca.Function("jacobian", [x, p], list(jacobian), ["x", "p"], ["g", "jac_g_x"]),
        "hess_lag": ca.Function(
            "hessian", [x, p, lam_f, lam_g], [hessian], ["x", "p", "lam_f", "lam_g"], ["triu_hess_gamma_x_x"]
        ),
    }
