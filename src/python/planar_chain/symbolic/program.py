"""Straight-line programs: what is to be computed in order, with everything that occurs twice computed once.

A program is a list of pairs (symbol, expression), each in terms of t, q, qd, letters and symbols before it, as sympy.cse
returns them. Sine and cosine of an angle are computed once; those of differences of angles are made from them."""

import itertools

import sympy as sp

from .closed import with_rotors
from .coordinates import NONE
from .formulas import Formulas
from .linear import slope

OUTPUTS = ("M", "f", "qdd", "J_c", "c", "phi", "A", "B")


class Program:
    """The program of one Formulas. outputs: {name: matrix}, see OUTPUTS; steps: pairs (symbol, expression).

    linearize: whether A and B of ẋ = A x + B δτ, with x = (δq, δq̇), are among the outputs. added: symbols for the torques about which they
    are, beside all that acts; 0 in driven joints."""

    def __init__(self, formulas: Formulas, linearize=False):
        self.formulas, self.n = formulas, len(formulas.q)
        self.steps, self.outputs = [], {}
        self.coordinates, self.conditions = formulas.chain.coordinates, len(formulas.chain.rows)
        self._names = (sp.Symbol(f"x{k}") for k in itertools.count())
        self._angles()
        self._point_forces()
        self.steps += formulas.compact.coefficients.items()
        self._equations()
        self._relative_rows()
        self._accelerations()
        self.added = sp.Matrix([0 if j in formulas.driven else sp.Symbol(f"added_{j + 1}", real=True) for j in range(self.n)])
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
        """Laws of time, absolute angles, their sines and cosines."""
        of, chain = self.formulas, self.formulas.chain
        first = {law: symbol for symbol, law in reversed(list(of.given.items()))}  # of equal laws
        self.steps += [(symbol, law if first[law] is symbol else first[law]) for symbol, law in of.given.items()]
        self.swap = {}  # what stands for functions of angles
        angle, rate = chain.phi, chain.phid
        revolute = self.coordinates.revolute
        for i in revolute:
            self.swap[of.theta[i]] = angle = self.put(angle + of.q[i], f"theta_{i + 1}")
            self.swap[of.omega[i]] = rate = self.put(rate + of.qd[i], f"omega_{i + 1}")
        self.angles = [self.swap[of.theta[i]] for i in revolute]
        c, s = ({i: self.put(function(self.swap[of.theta[i]]), f"{name}_{i + 1}") for i in revolute}
                for function, name in ((sp.cos, "cos"), (sp.sin, "sin")))
        theta = {i: of.theta[i] for i in revolute}
        if NONE in self.coordinates.turner and chain.phi != 0:  # bodies that turn with the base
            theta = {NONE: chain.phi, **theta}
            c[NONE], s[NONE] = self.put(sp.cos(chain.phi)), self.put(sp.sin(chain.phi))
        for i, own in theta.items():
            self.swap[sp.cos(own)], self.swap[sp.sin(own)] = c[i], s[i]
            for j in [j for j in theta if j < i]:
                between = theta[j] - own
                self.swap[sp.cos(between)] = self.put(c[i] * c[j] + s[i] * s[j], f"cos_{j + 1}_{i + 1}")
                sine = self.put(s[j] * c[i] - c[j] * s[i], f"sin_{j + 1}_{i + 1}")
                self.swap[sp.sin(between)], self.swap[sp.sin(-between)] = sine, -sine

    def _swapped(self, expressions):
        """In terms of what is computed, with common subexpressions as steps."""
        shared, reduced = sp.cse([e.xreplace(self.swap) for e in expressions], symbols=self._names, order="none")
        self.steps += shared
        return [self.put(e) for e in reduced]

    def _point_forces(self):
        for force in self.formulas.point_forces:
            self.steps += zip(force.start, self._swapped(force.start.values()))
            self.steps += force.steps.items()

    def _equations(self):
        """M_θ, f_θ without the torques of joints, and those torques; J_θ and c of a tip that is held."""
        of, n = self.formulas, self.n
        self.tau = sp.Matrix([0 if j in of.driven else self.put(of.tau[j].xreplace(self.swap), f"tau_{j + 1}") for j in range(n)])
        upper = [(i, j) for i in range(n) for j in range(i, n)]
        M_theta = with_rotors(of.compact.bodies, of.J, self.coordinates)
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
        """T times these n numbers, from row `first` on: for each row the sum over `outwards` of coordinates.py."""
        sums, revolute = list(values), self.coordinates.revolute
        for i, outer in reversed([(i, outer) for i, outer in zip(revolute, revolute[1:]) if i >= first]):
            sums[i] = self.put(sums[i] + sums[outer])
        return sums

    def _accelerations(self):
        """q̈ and φ, by M q̈ − J_cᵀ φ = f, J_c q̈ = c. Bodies without a free joint between them turn alike, but for what is given: they
        are one group."""
        of, n = self.formulas, self.n
        self.free = [i for i in range(n) if i not in of.driven]
        revolute = self.coordinates.revolute
        turning = [i for i in self.free if i in revolute]
        ends = dict(zip(turning, turning[1:] + [n]))
        self.groups = [[j for j in revolute if i <= j < ends[i]] if i in revolute else [i] for i in self.free]
        self.turns = sp.zeros(n, 1)  # ẍ from driven joints alone
        for i, k in enumerate(self.coordinates.inner):
            before = self.turns[k] if k != NONE else 0
            self.turns[i] = self.put(before + of.qdd[i]) if i in of.driven else before

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
        self.right = [*loads, *rest]
        turning, phi = self._motion(self.tau)
        self.outputs["qdd"] = self._relative(turning, of.qdd)
        self._drive_torques(self._outer(turning), phi)
        if self.conditions:
            self.outputs["phi"] = sp.Matrix(phi)

    def _motion(self, torques):
        """Accelerations of groups, and φ, under these torques in joints."""
        solution, size = self._solve(self.right, torques), len(self.groups)
        return solution[:size], [self.put(-value) for value in solution[size:]]

    def _solve(self, loads, torques):
        """Accelerations of groups, and −φ, of loads on bodies and right-hand sides of conditions, and of torques in joints."""
        right = [sum(loads[i] for i in group) + torque for group, torque in zip(self.groups, self._by_group(torques))]
        return self.factor.solve([self.put(value) for value in [*right, *loads[self.n:]]])

    def _by_group(self, torques):
        """In the rows of groups: the torque of the first joint, less that of the next group's."""
        rows = {i: torques[i] for i in self.free}
        for i, k in self._inner_groups():
            rows[k] -= torques[i]
        return list(rows.values())

    def _inner_groups(self):
        """Pairs of free revolute joints, one after another."""
        turning = [i for i in self.free if i in self.coordinates.revolute]
        return [(i, k) for k, i in zip(turning, turning[1:])]

    def _relative(self, turning, given):
        """The accelerations of all joints from those of groups: of free joints; and `given` ones of driven joints, n numbers or 0."""
        own, inner = dict(zip(self.free, turning)), dict(self._inner_groups())
        out = sp.zeros(self.n, 1)
        for i in range(self.n):
            if i in own:
                out[i] = self.put(own[i] - own[inner[i]]) if i in inner else own[i]
            elif given is not None:
                out[i] = given[i]
        return out

    def _outer(self, turning):
        """ẍ"""
        beta = list(self.turns)
        for value, group in zip(turning, self.groups):
            for i in group:
                beta[i] = self.put(value + self.turns[i])
        return beta

    def _drive_torques(self, beta, phi):
        """f of driven joints: M q̈ − J_cᵀ φ in these rows, so that the drive gives what it takes."""
        of, n = self.formulas, self.n
        if of.driven:
            inertia = self._sums([self.put(sum(self.M_theta[i, j] * beta[j] for j in range(n)) - sum(
                self.tip[j, i] * phi[j] for j in range(self.conditions))) for i in range(n)])
            for i in of.driven:
                self.outputs["f"][i] = inertia[i]

    # ---- Near a state ------------------------------------------------------------------------------

    def _linearize(self):
        """M ∂q̈ − J_cᵀ ∂φ = ∂(f − M q̈ + J_cᵀ φ), J_c ∂q̈ = ∂(c − J_c q̈), at the same q̈ and φ."""
        of, n = self.formulas, self.n
        turning, phi = self._motion(self.tau + self.added)
        by_angle = self._slopes_at_rest(self._outer(turning), phi)
        by_rate = self._swapped([slope(load, rate) for load in [*of.compact.loads, *of.compact.tip_rest] for rate in of.chain.xd])
        for force in of.point_forces:
            self._add_slopes(force, by_angle, by_rate)
        by_angle, by_rate = self._outwards(by_angle), self._outwards(by_rate)
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

    def _add_slopes(self, force, by_angle, by_rate):
        """Those of J_Xᵀ F, at the same J_X."""
        n, x = self.n, self.formulas.chain.x
        self.steps += force.tangents.items()
        J, W = (sp.Matrix(2, n, self._swapped(list(gradient))) for gradient in force.gradients(x))
        for slopes, change in zip((by_angle, by_rate), force.changes(J, W)):
            change = change.applyfunc(self.put)
            for i in range(n):
                for j in range(n):
                    slopes[i * n + j] = self.put(slopes[i * n + j] + J[:, i].dot(change[:, j]))

    def _slopes_at_rest(self, beta, phi):
        """∂(f_θ − M_θ β + J_θᵀ φ)_i/∂x_j at the same β, φ, rates and forces on points, row by row, and then ∂(c − J_θ β)_i/∂x_j."""
        of, n, x = self.formulas, self.n, self.formulas.chain.x
        slopes = self._swapped([slope(load, own) for load in [*of.compact.loads, *of.compact.tip_rest] for own in x])
        of_tip = [(k, i, j) for k in range(self.conditions) for i in range(n) for j in range(n) if of.compact.tip[k, i].has(x[j])]
        for (k, i, j), change in zip(of_tip, self._swapped([slope(of.compact.tip[k, i], x[j]) for k, i, j in of_tip])):
            row, condition = i * n + j, (n + k) * n + j
            slopes[row] = self.put(slopes[row] + change * phi[k])
            slopes[condition] = self.put(slopes[condition] - change * beta[i])
        # An entry of M_θ depends on the difference of two angles, and on displacements.
        turner = self.coordinates.turner
        changing = [(i, k, j) for i in range(n) for k in range(i, n) for j in range(n)
                    if j != turner[i] and of.compact.bodies[i, k].has(x[j])]
        for (i, k, j), change in zip(changing, self._swapped([slope(of.compact.bodies[i, k], x[j]) for i, k, j in changing])):
            for row, other in [(i, k)] + [(k, i)] * (k > i):
                slopes[row * n + j] = self.put(slopes[row * n + j] - change * beta[other])
                if j in self.coordinates.revolute and turner[i] != NONE:
                    slopes[row * n + turner[i]] = self.put(slopes[row * n + turner[i]] + change * beta[other])
        return slopes

    def _outwards(self, slopes):
        """∂/∂q_j: of all x_j from j outwards."""
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
