"""M q̈ = f near a state: M δq̈ = K δq + D δq̇ + δτ, in terms of the coordinates x as in closed.py."""

import types

import sympy as sp

from .letters import state_symbols


def slope(expression, by):
    """The derivative; that of sign() is 0, as a joint that moves continues to move."""
    if isinstance(expression, sp.Add):
        return sp.Add(*(slope(term, by) for term in expression.args))
    if not expression.has(by):
        return sp.Integer(0)
    if isinstance(expression, sp.Mul):  # SymPy takes long over products with constants
        constants = [part for part in expression.args if not part.has(by)]
        if constants:
            return sp.Mul(*constants, slope(sp.Mul(*(part for part in expression.args if part.has(by))), by))
    return sp.diff(expression, by).replace(sp.DiracDelta, lambda *_: sp.Integer(0))


def linear(of):
    """K_theta, D_theta, K_tau, D_tau, K_c, D_c of Formulas, with which, as q̇ and the accelerations of the state stay,

        K = ∂(f − M q̈ + J_cᵀ φ)/∂q = T K_θ Tᵀ + K_τ        D = ∂f/∂q̇ = T D_θ Tᵀ + D_τ

    points: J and W of each of point_forces, ∂X/∂x and ∂v/∂x, 2 × n. It adds Jᵀ (∂F/∂X J + ∂F/∂v W) to K_θ, Jᵀ ∂F/∂v J to D_θ.
    If the tip is held, K_c and D_c are those with which J_c δq̈ = K_c Tᵀ δq + D_c Tᵀ δq̇.
    beta: ẍ of the state (coordinates.py), as the torques have it about which A and B are. K_τ and D_τ are diagonal, and 0 at driven joints."""
    n, loads, inertia, tip, c = len(of.q), of.closed.loads_theta, of.closed.M_theta, of.closed.J_theta, of.closed.c
    beta, x, xd = state_symbols("beta", n), of.chain.x, of.chain.xd

    def by_angle(i, j):
        return slope(loads[i], x[j]) - sp.Add(*(slope(inertia[i, k], x[j]) * beta[k] for k in range(n))) + sp.Add(
            *(slope(tip[k, i], x[j]) * of.phi[k] for k in range(tip.rows)))

    def of_tip(k, j):
        return slope(c[k], x[j]) - sp.Add(*(slope(tip[k, i], x[j]) * beta[i] for i in range(n)))

    def of_torques(by):
        return sp.diag(*(0 if j in of.driven else slope(of.tau[j], by[j]) for j in range(n)))

    return types.SimpleNamespace(
        beta=beta, K_theta=sp.Matrix(n, n, by_angle), D_theta=sp.Matrix(n, n, lambda i, j: slope(loads[i], xd[j])),
        points=[tuple(force.gradients(x)) for force in of.point_forces],
        K_c=sp.Matrix(tip.rows, n, of_tip), D_c=sp.Matrix(tip.rows, n, lambda k, j: slope(c[k], xd[j])),
        K_tau=of_torques(of.q), D_tau=of_torques(of.qd))
