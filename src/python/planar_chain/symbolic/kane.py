"""Kane's equations in letters by the steps of the notes, as src/dynamics/kane.cpp takes them with numbers."""

import types

import sympy as sp


def cross_row(r):
    """S_r = [−r_y, r_x]: the row of k̂ × r"""
    return sp.Matrix([[-r[1], r[0]]])


def rows(chain, body_matrix):
    """n×2n: S_r^i X_i at i = j, S_p^i X_i at i < j, with the 2×2 matrix X_i of body i. B has X = S_i0, C has [ω^i] S_i0. r^i and p^i of a
    prismatic joint's body are from the outer pin before it: q_i d_i longer."""
    n = chain.n
    matrix = sp.zeros(n, 2 * n)
    for i in range(n):
        X = body_matrix(i)
        for j in range(i, n):
            matrix[i, 2 * j:2 * j + 2] = cross_row(chain.displacement[i] + (chain.r[i] if i == j else chain.p[i])) * X
    return matrix


def turning(omega):
    """[ω] = Ṡ Sᵀ"""
    return sp.Matrix([[0, omega], [-omega, 0]])


def kane(chain):
    """Every matrix of the notes: S, T, B, C, V_pd, W_pd, A_1, A_2, A_3, F, M_ext, tau, f_ext, M, f; J_c, c of a tip that is held."""
    n, of = chain.n, types.SimpleNamespace()
    of.S = chain.S
    of.T = sp.Matrix(n, n, lambda i, j: 1 if i in chain.coordinates.revolute and i <= j else 0)
    of.B = rows(chain, lambda i: chain.S[i])
    of.C = rows(chain, lambda i: turning(chain.omega[i]) * chain.S[i])

    # Partial velocities, and inertia
    m = sp.diag(*(mass for mass in chain.m for _ in "xy"))
    inertia = sp.diag(*chain.I)
    along_axes = sp.Matrix(n, 2 * n, lambda i, j: chain.turned_axes[i][j % 2] if i <= j // 2 else 0)
    of.V_pd, of.W_pd = of.T * of.B + along_axes, of.T
    of.A_1, of.A_2, of.A_3 = of.T * of.C * m, of.V_pd * m, of.T * inertia

    # Kane: V_pd (F + F_in) + W_pd (M + M_in) + τ = 0, on a base with p̈ and φ̈
    of.F, of.M_ext, of.tau = chain.F, chain.M, chain.tau
    of.f_ext = of.V_pd * of.F + of.W_pd * of.M_ext + of.tau
    base = sp.Matrix([component for j in range(n) for component in chain.pdd + coriolis(chain, j + 1)])
    ones = sp.ones(n, 1)
    acceleration = of.C.T * chain.omega + of.B.T * ones * chain.phidd + base  # of the centres of mass where q̈ = 0
    of.f = of.f_ext - of.V_pd * m * acceleration - of.W_pd * inertia * ones * chain.phidd
    of.M = of.V_pd * of.A_2.T + of.W_pd * of.A_3.T + sp.diag(*chain.J)
    take_tip(chain, of, ones)
    return of


def coriolis(chain, count):
    """Σ 2 ω_i q̇_i k̂×d_i of the first `count` bodies."""
    return sum((2 * chain.omega[i] * chain.qd[i] * sp.Matrix([-d[1], d[0]]) for i, d in enumerate(chain.turned_axes[:count])), sp.zeros(2, 1))


def take_tip(chain, of, ones):
    """J_c q̈ = c: along the rows c_j the tip has the acceleration ẍ_T. V_tip: partial velocities of the tip, n×2."""
    def outer(body_matrix):
        return sp.Matrix([cross_row(chain.displacement[i] + chain.p[i]) * body_matrix(i) for i in range(chain.n)])

    B, C = outer(lambda i: chain.S[i]), outer(lambda i: turning(chain.omega[i]) * chain.S[i])
    of.V_tip = of.T * B + sp.Matrix([d.T for d in chain.turned_axes])
    c_rows = sp.Matrix(len(chain.rows), 2, lambda j, axis: chain.rows[j][axis])
    of.J_c = c_rows * of.V_tip.T
    of.c = c_rows * (chain.tip_acceleration - chain.pdd - coriolis(chain, chain.n) - C.T * chain.omega - B.T * ones * chain.phidd)
