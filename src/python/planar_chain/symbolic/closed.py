"""The closed form in the coordinates x of coordinates.py, as a textbook writes it: M_θ ẍ = f_θ. Most x are absolute angles θ.

Rows for x instead of q need no T. Row i of B has the velocity of each centre of mass where ẋ_i = 1: its lever k̂ × … behind a
revolute joint, from the joint to the centre of mass along the bodies that turn with it; the axis d_i behind a prismatic one. With
the row T of coordinates.py,

    M_q = T M_θ Tᵀ        M_θ = B diag(m) Bᵀ + diag(I) + rotors
    f   = T f_θ           f_θ = B F + M − B diag(m) a_0 − I φ̈ + (τ_i − τ_k of the next revolute joint k)

a_0 has the accelerations where ẍ = 0: p̈ of the base; φ̈ with all rows of angles; −ω² times the levers, by the rows C of angles; and
2 ω q̇_i k̂ × d_i of a prismatic joint whose body turns. The bodies that turn with the base have a row of B too, which has no x.

Row i of B is linear in the cosine and sine of its angle, so an entry of B diag(m) Bᵀ is bilinear in those of θ_i and θ_j. As turning
the whole chain changes no inertia, it is a cos(θ_j − θ_i) + b sin(θ_j − θ_i). Two places give a and b: θ_i = 0, and θ_j = 0 or π/2.
They are polynomials in the displacements q of prismatic joints behind revolute ones.

The tip moves as all that hangs on the last pin would: with the outer columns B_i of all bodies,

    J_c = J_θ Tᵀ          J_θ,ji = c_j·B_i          c_j = c_j·(ẍ_T − a_0 of the tip)"""

import types

import sympy as sp

from .coordinates import NONE
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
    """Row i of B in the columns of bodies. i: a joint, or NONE for the base. From body end[i] + 1 on all columns are alike."""

    def __init__(self, chain):
        self.chain, self.coordinates, self._known, self._names = chain, chain.coordinates, {}, {}
        self.outer_mass = [sp.Add(*chain.m[i + 1:]) for i in range(chain.n)]
        self.angle = {NONE: chain.phi, **dict(enumerate(chain.theta))}
        self.end = {i: max(self.coordinates.turned_by(i), default=i) for i in (NONE, *self.coordinates.revolute)}
        self.end.update({i: i for i in self.coordinates.prismatic})
        self.displacements = [chain.q[i] for i in self.coordinates.prismatic]

    def coefficient(self, expression):
        """A symbol for what multiplies a sine, a cosine or a power of a displacement: SymPy is quick with symbols, and takes long over
        products of sums."""
        powers = [q for q in self.displacements if expression.has(q)]
        if powers:
            return sp.Add(*(times(self.coefficient(value), sp.Mul(*(q ** k for q, k in zip(powers, exponents))))
                            for exponents, value in sp.Poly(expression, *powers).terms()))
        expression = sp.factor_terms(expression)
        if expression.is_Atom or expression.is_Mul and len(expression.args) == 2 and expression.args[0] == -1:
            return expression
        if -expression in self._names:
            return -self._names[-expression]
        return self._names.setdefault(expression, sp.Symbol(f"k{len(self._names)}"))

    def coefficients(self):
        """{symbol: what it stands for}"""
        return {symbol: expression for expression, symbol in self._names.items()}

    def lever(self, i, body):
        """The vector from joint i, or the base, to the centre of mass of this body, or to the last outer pin, along bodies that turn
        with x_i."""
        chain, total = self.chain, sp.zeros(2, 1)
        for k in self.coordinates.turned_by(i):
            if k <= body:
                total += chain.displacement[k] + (chain.r[k] if k == body else chain.p[k])
        return total

    def at(self, i, body, heading, spin=None):
        """The row in this body's column, where (cos, sin) of its angle is `heading`; with `spin` = [ω^i] that of C."""
        body = min(body, self.end[i] + 1)
        key = i, body, heading, spin is None
        if key not in self._known:
            c, s = heading
            S = sp.Matrix([[c, s], [-s, c]])
            row = self.chain.axes[i].T if i in self.coordinates.prismatic else cross_row(self.lever(i, body))
            self._known[key] = row * (S if spin is None else spin * S)
        return self._known[key]

    def columns(self, first, end):
        """Pairs: a body, and a slice of all that have columns like it; from the first to the end one by one."""
        return [*((k, slice(k, k + 1)) for k in range(first, end + 1)), (end + 1, slice(end + 1, self.chain.n))]

    def inertia(self, i, j, spin=None):
        """B_i diag(m) B_jᵀ, and I_i where i = j; or with `spin` = [ω^j] B_i diag(m) C_jᵀ."""
        if j < i and spin is None:
            i, j = j, i
        first, last = min(i, j), max(i, j)
        masses = [(k, sp.Add(*self.chain.m[like])) for k, like in self.columns(last, max(self.end[i], self.end[j]))]

        def at(heading):
            """θ_first = 0, θ_last in this direction."""
            def row(k, body):
                return self.at(k, body, ALONG if k == first else heading, spin if k is j else None)
            return sp.Add(*(times(m, dot(row(i, k), row(j, k))) for k, m in masses))

        if i == j and i in self.coordinates.prismatic:
            return self.coefficient(self.chain.m[i] + self.outer_mass[i])
        if i == j:
            return self.coefficient(sp.Add(*(self.chain.I[k] for k in self.coordinates.turned_by(i)), at(ALONG)))
        between = self.angle[last] - self.angle[first]
        if between == 0:
            return self.coefficient(at(ALONG))
        return times(self.coefficient(at(ALONG)), sp.cos(between)) + times(self.coefficient(at(ACROSS)), sp.sin(between))

    def along(self, direction, i, spin=None):
        """The rate of the tip along `direction` per rate of x_i; or with `spin` = [ω^i] the row of C."""
        angle = self.angle[i]
        if angle == 0:
            return dot(direction, self.at(i, self.chain.n, ALONG, spin))
        along, across = (self.coefficient(dot(direction, self.at(i, self.chain.n, heading, spin))) for heading in (ALONG, ACROSS))
        return times(along, sp.cos(angle)) + times(across, sp.sin(angle))

    def force(self, i, forces, moment=sp.Integer(0)):
        """B_i F + M_i, where F has the components x_1 y_1 …, and M_i is linear in cos θ_i, sin θ_i."""
        sums = [(k, [sp.Add(*forces[axis::2][like]) for axis in (0, 1)]) for k, like in self.columns(i, self.end[i])]
        angle = self.angle[i]
        c, s = sp.cos(angle), sp.sin(angle)
        constant = moment.xreplace({c: 0, s: 0})
        total = constant
        for heading, function in ((ALONG, c), (ACROSS, s))[:1 if angle == 0 else 2]:
            part = moment.xreplace(dict(zip((c, s), map(sp.Integer, heading)))) - constant
            total += times(self.coefficient(sp.Add(*(dot(self.at(i, k, heading), each) for k, each in sums), part)), function)
        return total


def compact(chain):
    """bodies: M_θ without rotors. loads: f_θ without the torques of joints. tip: J_θ; tip_rest: c. All in terms of `coefficients`,
    {symbol: expression}."""
    n, rows, coordinates = chain.n, Rows(chain), chain.coordinates
    bodies, loads = sp.zeros(n, n), sp.zeros(n, 1)
    for i in range(n):
        for j in range(i, n):
            bodies[i, j] = bodies[j, i] = rows.inertia(i, j)
    of_base = [-m * component for m in chain.m for component in chain.pdd]
    angles = [(NONE, chain.phid)] * (chain.phi != 0) + [(j, chain.omega[j]) for j in coordinates.revolute]

    def of_motion(row, spun):
        """The terms of turning bodies and the base: of ω², φ̈ and Coriolis. row(j): a row of M_θ or J_θ; spun(j, rate): by C."""
        terms = [each_times(spun(j, -1), omega ** 2) - each_times(row(j), chain.phidd) for j, omega in angles]
        return sp.Add(*terms, *(-each_times(spun(j, 1), 2 * chain.omega[j] * chain.qd[j]) for j in coordinates.prismatic))

    for i in range(n):
        # Weights with the base's acceleration, which equals a tilted gravity; loads.
        moment = sp.Add(*(chain.M[k] for k in coordinates.turned_by(i)))
        loads[i] = rows.force(i, [a + b for a, b in zip(chain.weights, of_base)])
        loads[i] += rows.force(i, list(chain.F - chain.weights), moment)
        loads[i] += of_motion(lambda j, i=i: bodies[i, j] if j != NONE else rows.inertia(i, j),
                              lambda j, rate, i=i: rows.inertia(i, j, turning(rate)) if j != i else sp.Integer(0))
    tip = sp.Matrix(len(chain.rows), n, lambda j, i: rows.along(chain.rows[j], i))
    tip_rest = sp.Matrix([dot(row, chain.tip_acceleration - chain.pdd) + of_motion(
        lambda i, row=row: rows.along(row, i), lambda i, rate, row=row: rows.along(row, i, turning(rate))) for row in chain.rows])
    return types.SimpleNamespace(bodies=bodies, loads=loads, tip=tip, tip_rest=tip_rest, coefficients=rows.coefficients())


def with_rotors(bodies, J, coordinates):
    """M_θ. A rotor resists q̈."""
    M_theta = bodies.copy()
    for i, k in enumerate(coordinates.inner):
        M_theta[i, i] += J[i]
        if k != NONE:
            M_theta[k, k] += J[i]
            M_theta[k, i] -= J[i]
            M_theta[i, k] -= J[i]
    return M_theta


def closed(chain, short):
    """M_theta, f_theta, J_theta: for x; loads_theta: f_theta without the torques of joints. M, f, J_c: for q. c. short: by compact()."""
    bodies, loads, tip, c = (matrix.xreplace(short.coefficients) for matrix in (short.bodies, short.loads, short.tip, short.tip_rest))
    outwards = chain.coordinates.outwards
    f_theta = loads + chain.tau
    for i, k in enumerate(chain.coordinates.inner):  # a joint's torque acts against the body before too
        if k != NONE:
            f_theta[k] -= chain.tau[i]
    return types.SimpleNamespace(
        M_theta=with_rotors(bodies, chain.J, chain.coordinates), loads_theta=loads, f_theta=f_theta, J_theta=tip, c=c,
        J_c=sp.Matrix(tip.rows, chain.n, lambda j, i: sp.Add(*(tip[j, k] for k in outwards(i)))), M=relative(chain, bodies) + sp.diag(*chain.J),
        f=sp.Matrix([sp.Add(*(loads[k] for k in outwards(i))) + chain.tau[i] for i in range(chain.n)]))


def relative(chain, bodies):
    """T M_θ Tᵀ, with what does not depend on angles in brackets."""
    n, outwards = chain.n, chain.coordinates.outwards
    still = [grouped(chain, sp.Add(*(bodies[k, k] for k in outwards(i)))) for i in range(n)]

    def entry(i, j):
        rows, columns = outwards(i), outwards(j)
        return (still[max(i, j)] if max(i, j) in rows and max(i, j) in columns else 0) + sp.Add(
            *(bodies[a, b] for a in rows for b in columns if a != b))
    return sp.Matrix(n, n, entry)


def grouped(chain, expression):
    """The expression as short as in a textbook: I_1 + m_1 r_1² + (m_2 + m_3) (p_1² + r_2²)."""
    by_mass, by_length = {}, {}
    masses = [m for m in chain.m if m.is_Symbol]
    for term in sp.Add.make_args(sp.expand(expression)):
        rest, mass = term.as_independent(*masses, as_Add=False)
        by_mass.setdefault(mass, []).append(rest)
    for mass, rests in by_mass.items():
        by_length.setdefault(sp.Add(*rests), []).append(mass)
    return sp.Add(*(rest * sp.Add(*own) for rest, own in by_length.items()))
