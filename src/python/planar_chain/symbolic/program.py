"""Straight-line programs: what is to be computed in order, with everything that occurs twice computed once.

A program is a list of pairs (symbol, expression), each in terms of t, q, qd, letters and symbols before it, as sympy.cse
returns them. Sine and cosine of an angle are computed once; those of differences of angles are made from them."""

import itertools

import sympy as sp

from .closed import with_rotors
from .formulas import Formulas
from .linear import slope

OUTPUTS = ("M", "f", "qdd", "J_c", "c", "phi", "A", "B")


class Program:
    """The program of one Formulas. outputs: {name: matrix}, see OUTPUTS; steps: pairs (symbol, expression).

    linearize: whether A and B of ẋ = A x + B δτ, with x = (δq, δq̇), are among the outputs."""

    def __init__(self, formulas: Formulas, linearize=False):
        self.formulas, self.n = formulas, len(formulas.q)
        self.steps, self.outputs = [], {}
        self.slides, self.conditions = formulas.chain.slides, len(formulas.chain.rows)
        self._names = (sp.Symbol(f"x{k}") for k in itertools.count())
        self._angles()
        self._equations()
        self._relative_rows()
        self._accelerations()
        self._drive_torques()
        if linearize:
            self._linearize()
        self.outputs = {name: self.outputs[name] for name in OUTPUTS if name in self.outputs}

    # ---- Steps -----------------------------------------------------------------------------------

    def put(self, expression, name=None):
        """A symbol for the expression; the expression itself if it is a number or a symbol."""
        expression = sp.sympify(expression)
        if expression.is_Atom:
            return expression
        symbol = sp.Symbol(name) if name else next(self._names)
        self.steps.append((symbol, expression))
        return symbol

    def needed(self, *names):
        """The steps without which these outputs cannot be computed."""
        wanted = set().union(*(self.outputs[name].free_symbols for name in names))
        steps = []
        for symbol, expression in reversed(self.steps):
            if symbol in wanted:
                wanted |= expression.free_symbols
                steps.append((symbol, expression))
        return steps[::-1]

    # ---- What is computed ------------------------------------------------------------------------

    def _angles(self):
        """Laws of time, coefficients, absolute angles, their sines and cosines."""
        of, chain = self.formulas, self.formulas.chain
        first = {law: symbol for symbol, law in reversed(list(of.given.items()))}  # of equal laws
        self.steps += [(symbol, law if first[law] is symbol else first[law]) for symbol, law in of.given.items()]
        self.steps += of.compact.coefficients.items()
        self.swap = {}  # what stands for functions of angles
        angle, rate = chain.phi, chain.phid
        turning = range(self.slides, self.n)
        for i in turning:
            self.swap[of.theta[i]] = angle = self.put(angle + of.q[i], f"theta_{i + 1}")
            self.swap[of.omega[i]] = rate = self.put(rate + of.qd[i], f"omega_{i + 1}")
        self.angles = [self.swap[of.theta[i]] for i in turning]
        c, s = ({i: self.put(function(self.swap[of.theta[i]]), f"{name}_{i + 1}") for i in turning}
                for function, name in ((sp.cos, "cos"), (sp.sin, "sin")))
        turned = self.slides - 1 if self.slides and chain.phi != 0 else self.slides  # slides turn alike
        if turned < self.slides:
            c[turned], s[turned] = self.put(sp.cos(chain.phi)), self.put(sp.sin(chain.phi))
        for i in range(turned, self.n):
            self.swap[sp.cos(of.theta[i])], self.swap[sp.sin(of.theta[i])] = c[i], s[i]
            for j in range(turned, i):
                between = of.theta[j] - of.theta[i]
                self.swap[sp.cos(between)] = self.put(c[i] * c[j] + s[i] * s[j], f"cos_{j + 1}_{i + 1}")
                sine = self.put(s[j] * c[i] - c[j] * s[i], f"sin_{j + 1}_{i + 1}")
                self.swap[sp.sin(between)], self.swap[sp.sin(-between)] = sine, -sine

    def _swapped(self, expressions):
        """In terms of what is computed, with common subexpressions as steps."""
        shared, reduced = sp.cse([e.xreplace(self.swap) for e in expressions], symbols=self._names, order="none")
        self.steps += shared
        return [self.put(e) for e in reduced]

    def _equations(self):
        """M_θ, f_θ without the torques of joints, and those torques; J_θ and c of a tip that is held."""
        of, n = self.formulas, self.n
        self.tau = sp.Matrix([0 if j in of.driven else self.put(of.tau[j].xreplace(self.swap), f"tau_{j + 1}") for j in range(n)])
        upper = [(i, j) for i in range(n) for j in range(i, n)]
        M_theta = with_rotors(of.compact.bodies, of.J, self.slides)
        values = self._swapped([*(M_theta[i, j] for i, j in upper), *of.compact.loads, *of.compact.tip, *of.compact.tip_rest])
        loads, tip = len(upper), len(upper) + n
        self.M_theta, self.loads = sp.zeros(n, n), values[loads:tip]
        self.tip, self.tip_rest = sp.Matrix(self.conditions, n, values[tip:tip + self.conditions * n]), values[tip + self.conditions * n:]
        for (i, j), value in zip(upper, values):
            self.M_theta[i, j] = self.M_theta[j, i] = value

    def _relative_rows(self):
        """M and f of the rows for q: sums from body i outwards."""
        n = self.n
        columns = sp.Matrix([self._sums(self.M_theta.row(i)) for i in range(n)])
        self.outputs["M"] = sp.zeros(n, n)
        for j in range(n):
            for i, value in enumerate(self._sums(columns.col(j), j)):
                if i >= j:
                    self.outputs["M"][i, j] = self.outputs["M"][j, i] = value
        self.outputs["f"] = sp.Matrix([self.put(a + b) for a, b in zip(self._sums(self.loads), self.tau)])
        if self.conditions:
            self.outputs["J_c"] = sp.Matrix([self._sums(row) for row in self.tip.tolist()])
            self.outputs["c"] = sp.Matrix(self.tip_rest)

    def _sums(self, values, first=0):
        """T times these n numbers, from row `first` on: for each row the sum from body i outwards; a slide's own. 0 before."""
        sums = list(values)
        for i in reversed(range(max(first, self.slides), self.n - 1)):
            sums[i] = self.put(sums[i] + sums[i + 1])
        return sums

    def _accelerations(self):
        """q̈ and φ, by M q̈ − J_cᵀ φ = f, J_c q̈ = c. Bodies without a free joint between them turn alike, but for what is given: they
        are one group."""
        of, n = self.formulas, self.n
        self.free = [i for i in range(n) if i not in of.driven]
        turning = [i for i in self.free if i >= self.slides]
        self.groups = [range(i, i + 1) for i in self.free if i < self.slides]
        self.groups += [range(start, end) for start, end in zip(turning, turning[1:] + [n])]
        self.turns = sp.zeros(n, 1)  # of each body against the base, from driven joints alone
        sum_of_given = sp.Integer(0)
        for i in range(n):
            if i < self.slides:
                self.turns[i] = of.qdd[i] if i in of.driven else 0
                continue
            if i in of.driven:
                sum_of_given = self.put(sum_of_given + of.qdd[i])
            self.turns[i] = sum_of_given

        size = len(self.groups)
        H = sp.zeros(size + self.conditions, size + self.conditions)
        for a in range(size):
            for b in range(a + 1):
                H[a, b] = H[b, a] = self.put(sum(self.M_theta[i, j] for i in self.groups[a] for j in self.groups[b]))
            for j in range(self.conditions):
                H[size + j, a] = H[a, size + j] = self.put(sum(self.tip[j, i] for i in self.groups[a]))
        self.factor = Factored(self, H)
        loads = [self.loads[i] - sum(self.M_theta[i, j] * self.turns[j] for j in range(n)) for i in range(n)]
        rest = [self.tip_rest[j] - sum(self.tip[j, i] * self.turns[i] for i in range(n)) for j in range(self.conditions)]
        solution = self._solve([*loads, *rest], self.tau)
        self.turning, self.phi = solution[:size], [self.put(-value) for value in solution[size:]]
        self.outputs["qdd"] = self._relative(self.turning, of.qdd)
        if self.conditions:
            self.outputs["phi"] = sp.Matrix(self.phi)

    def _solve(self, loads, torques):
        """Accelerations of groups, and −φ, of loads on bodies and right-hand sides of conditions, and of torques in joints."""
        right = [sum(loads[i] for i in group) + torque for group, torque in zip(self.groups, self._by_group(torques))]
        return self.factor.solve([self.put(value) for value in [*right, *loads[self.n:]]])

    def _by_group(self, torques):
        """In the rows of groups: the torque of the first joint, less that of the next group's."""
        own = [torques[i] for i in self.free] + [0]
        return [a - b if i >= self.slides else a for i, a, b in zip(self.free, own, own[1:])]

    def _relative(self, turning, given):
        """Of accelerations of groups: those of free joints; and `given` ones of driven joints, n numbers or 0."""
        out, before = sp.zeros(self.n, 1), sp.Integer(0)
        for i in range(self.n):
            if i in self.free:
                own = turning[self.free.index(i)]
                out[i] = self.put(own - before)
                before = own if i >= self.slides else before
            elif given is not None:
                out[i] = given[i]
        return out

    def _drive_torques(self):
        """f of driven joints: M q̈ − J_cᵀ φ in these rows, so that the drive gives what it takes."""
        of, n = self.formulas, self.n
        self.beta = [self.turns[i] for i in range(n)]  # θ̈ relative to the base
        for value, group in zip(self.turning, self.groups):
            for i in group:
                self.beta[i] = self.put(value + self.turns[i])
        if of.driven:
            inertia = self._sums([self.put(sum(self.M_theta[i, j] * self.beta[j] for j in range(n)) - sum(
                self.tip[j, i] * self.phi[j] for j in range(self.conditions))) for i in range(n)])
            for i in of.driven:
                self.outputs["f"][i] = inertia[i]

    # ---- Near a state ------------------------------------------------------------------------------

    def _linearize(self):
        """M ∂q̈ − J_cᵀ ∂φ = ∂(f − M q̈ + J_cᵀ φ), J_c ∂q̈ = ∂(c − J_c q̈), at the same q̈ and φ."""
        of, n = self.formulas, self.n
        by_angle = self._outwards(self._slopes_at_rest())
        by_rate = self._outwards(self._swapped([slope(load, omega) for load in [*of.compact.loads, *of.compact.tip_rest]
                                                for omega in of.chain.xd]))
        own = [[self.put(slope(of.tau[j], x[j]).xreplace(self.swap)) if j in self.free else 0 for j in range(n)]
               for x in (of.q, of.qd)]
        A, B = sp.zeros(2 * n, 2 * n), sp.zeros(2 * n, n)
        A[:n, n:] = sp.eye(n)
        for j in range(n):
            unit = sp.Matrix(n, 1, lambda i, _, j=j: 1 if i == j else 0)
            for half, (slopes, torque) in enumerate(zip((by_angle, by_rate), own)):
                A[n:, half * n + j] = self._relative(self._solve(slopes[:, j], torque[j] * unit), None)
            if j in self.free:
                B[n:, j] = self._relative(self._solve(sp.zeros(slopes.rows, 1), unit), None)
        self.outputs.update(A=A, B=B)

    def _slopes_at_rest(self):
        """∂(f_θ − M_θ β + J_θᵀ φ)_i/∂θ_j at the same β, φ and rates, row by row, and then ∂(c − J_θ β)_i/∂θ_j."""
        of, n, x = self.formulas, self.n, self.formulas.chain.x
        slopes = self._swapped([slope(load, theta) for load in [*of.compact.loads, *of.compact.tip_rest] for theta in x])
        of_tip = self._swapped([slope(of.compact.tip[j, i], x[i]) for j in range(self.conditions) for i in range(n)])
        inertias = self._swapped([slope(of.compact.bodies[i, j], x[j]) for i in range(n) for j in range(n)])
        for i in range(n):
            for j in range(n):
                if i != j and max(i, j) >= self.slides:  # an entry of M_θ depends on θ_j − θ_i alone
                    change = inertias[i * n + j] if j >= self.slides else -inertias[j * n + i]
                    if j >= self.slides:
                        slopes[i * n + j] = self.put(slopes[i * n + j] - change * self.beta[j])
                    if i >= self.slides:
                        slopes[i * n + i] = self.put(slopes[i * n + i] + change * self.beta[j])
            for j in range(self.conditions):  # row j of J_θ depends in column i on θ_i alone
                change, condition = of_tip[j * n + i], (n + j) * n + i
                slopes[i * n + i] = self.put(slopes[i * n + i] + change * self.phi[j])
                slopes[condition] = self.put(slopes[condition] - change * self.beta[i])
        return slopes

    def _outwards(self, slopes):
        """∂/∂q_j: of all bodies from j outwards."""
        return sp.Matrix([self._sums(row) for row in sp.Matrix(self.n + self.conditions, self.n, slopes).tolist()])


class Factored:
    """H = L D Lᵀ in steps of a program. H: a symmetric positive definite matrix, bordered by rows of conditions or not."""

    def __init__(self, program, H):
        self.put, self.size = program.put, H.shape[0]
        self.L, self.inverse = sp.zeros(*H.shape), []
        scaled = sp.zeros(*H.shape)  # L D
        for k in range(self.size):
            for i in range(k, self.size):
                scaled[i, k] = self.put(H[i, k] - sum(self.L[i, m] * scaled[k, m] for m in range(k)))
            self.inverse.append(self.put(1 / scaled[k, k]))
            for i in range(k + 1, self.size):
                self.L[i, k] = self.put(scaled[i, k] * self.inverse[k])

    def solve(self, right):
        """x of H x = right, lists."""
        x = []
        for i, value in enumerate(right):
            x.append(self.put(value - sum(self.L[i, k] * x[k] for k in range(i))))
        for i in reversed(range(self.size)):
            x[i] = self.put(x[i] * self.inverse[i] - sum(self.L[k, i] * x[k] for k in range(i + 1, self.size)))
        return x
