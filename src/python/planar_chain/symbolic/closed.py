"""The closed form in absolute angles, as a textbook writes it.

Rows for θ instead of q need no T: with V_pd = T B, the notes' M_q and f are

    M_q = T M_θ Tᵀ        M_θ = B diag(m) Bᵀ + diag(I) + rotors
    f   = T f_θ           f_θ = B F + M − B diag(m) (Cᵀ ω + Bᵀ 1 φ̈ + p̈) − I φ̈ + (τ_i − τ_{i+1})

Row i of B is linear in cos θ_i and sin θ_i, so an entry of B diag(m) Bᵀ is bilinear in those of θ_i and θ_j. As turning the
whole chain changes no inertia, it is a cos(θ_j − θ_i) + b sin(θ_j − θ_i). Two places give a and b: θ_i = 0, and θ_j = 0 or π/2.

The row of a slide in B is its rail's direction, for its own and all outer bodies. Its θ_i is that of the base, and T leaves its row
as it is. Where the base turns, f_θ has the accelerations of Kane's ofRail() too, and those of the slides' arms.

The tip moves as all that hangs on the last pin would: with the outer columns B_i and C_i of all bodies,

    J_c = J_θ Tᵀ          J_θ,ji = c_j·B_i          c_j = c_j·(ẍ_T − p̈ − Σ_i (C_iᵀ ω_i + B_iᵀ φ̈))"""

import types

import sympy as sp

from .kane import cross_row, turning

ALONG, ACROSS = (1, 0), (0, 1)  # (cos, sin) of 0 and of π/2


def times(a, b):
    """a b. SymPy takes long to find that zero times an expression is zero."""
    return sp.Integer(0) if a == 0 or b == 0 else a * b


def each_times(sum_of_terms, factor):
    """The sum of all terms times the factor."""
    return sp.Add(*(times(term, factor) for term in sp.Add.make_args(sum_of_terms)))


def dot(a, b):
    return times(a[0], b[0]) + times(a[1], b[1])


class Rows:
    """Row i of B in body i's own column, and in those of all bodies further out, which are alike."""

    def __init__(self, chain):
        self.chain, self._known, self._names = chain, {}, {}
        self.outer_mass = [sp.Add(*chain.m[i + 1:]) for i in range(chain.n)]

    def coefficient(self, expression):
        """A symbol for what multiplies a sine or cosine: SymPy is quick with symbols, and takes long over products of sums."""
        expression = sp.factor_terms(expression)
        if expression.is_Atom or expression.is_Mul and len(expression.args) == 2 and expression.args[0] == -1:
            return expression
        if -expression in self._names:
            return -self._names[-expression]
        return self._names.setdefault(expression, sp.Symbol(f"k{len(self._names)}"))

    def coefficients(self):
        """{symbol: what it stands for}"""
        return {symbol: expression for expression, symbol in self._names.items()}

    def at(self, i, place, spin=None):
        """The two where (cos θ_i, sin θ_i) is `place`; with `spin` = [ω^i] those of C."""
        key = i, place, spin is None
        if key not in self._known:
            c, s = place
            S = sp.Matrix([[c, s], [-s, c]])
            both = [self.chain.rails[i].T] * 2 if i < self.chain.slides else [cross_row(x[i]) for x in (self.chain.r, self.chain.p)]
            self._known[key] = [row * (S if spin is None else spin * S) for row in both]
        return self._known[key]

    def inertia(self, i, j, spin=None):
        """B_i diag(m) B_jᵀ, and I_i where i = j; or with `spin` = [ω^j] B_i diag(m) C_jᵀ."""
        if j < i and spin is None:
            i, j = j, i
        first, last = min(i, j), max(i, j)

        def at(place):
            """θ_first = 0, θ_last at this place."""
            left, right = (self.at(k, ALONG if k == first else place, spin if k is j else None) for k in (i, j))
            # The bodies that both move: the last of the two, and those further out.
            own = dot(left[0 if i == last else 1], right[0 if j == last else 1])
            return self.coefficient(times(self.chain.m[last], own) + times(self.outer_mass[last], dot(left[1], right[1])))

        if i == j and i < self.chain.slides:
            return self.coefficient(self.chain.m[i] + self.outer_mass[i])
        if i == j:
            own, outer = self.at(i, ALONG)
            return self.coefficient(self.chain.I[i] + times(self.chain.m[i], dot(own, own)) +
                                    times(self.outer_mass[i], dot(outer, outer)))
        between = self.chain.theta[last] - self.chain.theta[first]
        if between == 0:
            return at(ALONG)
        return times(at(ALONG), sp.cos(between)) + times(at(ACROSS), sp.sin(between))

    def along(self, direction, i, spin=None):
        """What body i moves the tip along `direction` where its rate is 1; or with `spin` = [ω^i] the row of C."""
        angle = self.chain.theta[i]
        if angle == 0:
            return dot(direction, self.at(i, ALONG, spin)[1])
        along, across = (self.coefficient(dot(direction, self.at(i, place, spin)[1])) for place in (ALONG, ACROSS))
        return times(along, sp.cos(angle)) + times(across, sp.sin(angle))

    def force(self, i, forces, moment=sp.Integer(0)):
        """B_i F + M_i, where F has the components x_1 y_1 …, and M_i is linear in cos θ_i, sin θ_i."""
        further = [sp.Add(*forces[2 * i + 2 + axis::2]) for axis in (0, 1)]
        angle = self.chain.theta[i]
        if angle == 0:
            rail = self.chain.rails[i]
            return self.coefficient(dot(rail, forces[2 * i:2 * i + 2]) + dot(rail, further))
        c, s = sp.cos(angle), sp.sin(angle)
        constant = moment.xreplace({c: 0, s: 0})
        total = constant
        for place, function in ((ALONG, c), (ACROSS, s)):
            own, outer = self.at(i, place)
            part = moment.xreplace(dict(zip((c, s), map(sp.Integer, place)))) - constant
            total += times(self.coefficient(dot(own, forces[2 * i:2 * i + 2]) + dot(outer, further) + part), function)
        return total


def compact(chain):
    """bodies: M_θ without rotors. loads: f_θ without the torques of joints. tip: J_θ; tip_rest: c. All in terms of `coefficients`,
    {symbol: expression}."""
    n, rows = chain.n, Rows(chain)
    bodies, loads = sp.zeros(n, n), sp.zeros(n, 1)
    for i in range(n):
        for j in range(i, n):
            bodies[i, j] = bodies[j, i] = rows.inertia(i, j)
    of_base, first = [], chain.pdd
    for j, m in enumerate(chain.m):
        of_base.extend(-m * (first + chain.carried(chain.r[j], j) if j < chain.slides else first))
        first += chain.carried(chain.p[j], j) if j < chain.slides else sp.zeros(2, 1)
    for i in range(n):
        # weights with the base's acceleration, which equals a tilted gravity; loads; what ω, φ̈ and turning rails add
        loads[i] = rows.force(i, [a + b for a, b in zip(chain.weights, of_base)])
        loads[i] += rows.force(i, list(chain.F - chain.weights), chain.M[i])
        for j, (along, across) in enumerate(chain.slid()):
            loads[i] -= each_times(bodies[i, j], along)
            loads[i] -= each_times(rows.inertia(i, j, turning(1)), across) if j != i else 0
        for j in range(chain.slides, n):
            if j != i:
                loads[i] += each_times(rows.inertia(i, j, turning(-1)), chain.omega[j] ** 2)
            loads[i] -= each_times(bodies[i, j], chain.phidd)
    tip = sp.Matrix(len(chain.rows), n, lambda j, i: rows.along(chain.rows[j], i))
    tip_rest = sp.Matrix([dot(row, chain.tip_acceleration - first) - sp.Add(
        *(each_times(tip[j, i], along) + each_times(rows.along(row, i, turning(1)), across)
          for i, (along, across) in enumerate(chain.slid()))) + sp.Add(
        *(each_times(rows.along(row, i, turning(-1)), chain.omega[i] ** 2) - each_times(tip[j, i], chain.phidd)
          for i in range(chain.slides, n))) for j, row in enumerate(chain.rows)])
    return types.SimpleNamespace(bodies=bodies, loads=loads, tip=tip, tip_rest=tip_rest, coefficients=rows.coefficients())


def with_rotors(bodies, J, slides):
    """M_θ. A rotor resists the difference of the accelerations of its two bodies; what slides does not turn."""
    M_theta = bodies.copy()
    for i in range(bodies.rows):
        M_theta[i, i] += J[i]
        if i > slides:
            M_theta[i - 1, i - 1] += J[i]
            M_theta[i - 1, i] -= J[i]
            M_theta[i, i - 1] -= J[i]
    return M_theta


def closed(chain, short):
    """M_theta, f_theta, J_theta: for θ; loads_theta: f_theta without the torques of joints. M, f, J_c: for q. c. short: by compact()."""
    bodies, loads, tip, c = (matrix.xreplace(short.coefficients) for matrix in (short.bodies, short.loads, short.tip, short.tip_rest))
    f_theta = loads + chain.tau
    for i in range(chain.slides + 1, chain.n):  # a joint's torque acts against the body before too
        f_theta[i - 1] -= chain.tau[i]
    return types.SimpleNamespace(
        M_theta=with_rotors(bodies, chain.J, chain.slides), loads_theta=loads, f_theta=f_theta, J_theta=tip, c=c,
        J_c=sp.Matrix(tip.rows, chain.n, lambda j, i: sp.Add(*(tip[j, k] for k in outwards(chain, i)))), M=relative(chain, bodies) + sp.diag(*chain.J),
        f=sp.Matrix([sp.Add(*(loads[k] for k in outwards(chain, i))) + chain.tau[i] for i in range(chain.n)]))


def outwards(chain, i):
    """The columns of row i of T that are 1."""
    return range(i, i + 1 if i < chain.slides else chain.n)


def relative(chain, bodies):
    """T M_θ Tᵀ, with what does not depend on angles in brackets."""
    n = chain.n
    still = [grouped(chain, sp.Add(*(bodies[k, k] for k in outwards(chain, i)))) for i in range(n)]

    def entry(i, j):
        rows, columns = outwards(chain, i), outwards(chain, j)
        return (still[max(i, j)] if max(i, j) in rows and max(i, j) in columns else 0) + sp.Add(
            *(bodies[a, b] for a in rows for b in columns if a != b))
    return sp.Matrix(n, n, entry)


def grouped(chain, expression):
    """As short as a textbook writes it: I_1 + m_1 r_1² + (m_2 + m_3) (p_1² + r_2²)."""
    by_mass, by_length = {}, {}
    masses = [m for m in chain.m if m.is_Symbol]
    for term in sp.Add.make_args(sp.expand(expression)):
        rest, mass = term.as_independent(*masses, as_Add=False)
        by_mass.setdefault(mass, []).append(rest)
    for mass, rests in by_mass.items():
        by_length.setdefault(sp.Add(*rests), []).append(mass)
    return sp.Add(*(rest * sp.Add(*own) for rest, own in by_length.items()))
