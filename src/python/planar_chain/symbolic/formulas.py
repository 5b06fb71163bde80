"""The equations of motion M q̈ = f of a scene as SymPy's objects."""

import copy
import functools
import types

from .chain import ChainInLetters, read
from .closed import closed, compact
from .kane import kane
from .letters import T, state_symbols, tidy_numbers

MATRICES = ("bodies", "loads", "tip", "tip_rest")  # of compact()


def formulas(scene):
    """The equations of motion of a Scene as formulas in the letters of the theory. See Formulas.

    Raises NoFormula for what cannot be written: chains of more than ten links, tables of more than a hundred times."""
    return Formulas(ChainInLetters(read(scene)))


class Formulas:
    """M q̈ = f of one scene. A number that is zero in the scene has no letter, and is in no formula.

    letters           {symbol: Letter} with value, unit and meaning
    t, q, qd, qdd     the time; relative angles, rates and accelerations: n×1. A driven joint's q̈ is a letter of `given`
    theta, omega      absolute angles and angular velocities: symbols, see `absolute`
    acting            {symbol: expression in theta, omega, q, qd, t and symbols before it}: air drag and springs to the ground
    given             {symbol: expression in t}: the base's motion, driven joints' q̈, factors of loads
    S, T, B, C, V_pd, W_pd, A_1, A_2, A_3, F, M_ext, tau, f_ext, M, f
                      the matrices of the notes, by their steps. S: a list
    closed            M_theta, f_theta: the closed form in absolute angles, M_θ θ̈ = f_θ (relative to a base that turns);
                      M, f: the same for the rows of q
    J_c, c            M q̈ = f + J_cᵀ φ and J_c q̈ = c where the tip is held; no rows where it is free. Also in `closed`, with J_theta
    phi               φ, the forces that hold the tip
    compact           bodies, loads: M_θ and f_θ without rotors and torques of joints, with a symbol for each coefficient
    driven            numbers of driven joints, from 0 on. tau and f have a letter tau_j there: what the drive gives, so that
                      row j of M q̈ = f holds

    Friction is −c sign(q̇), of a joint that moves; no formula describes joints that stick. A prismatic joint, as of a cart or a
    telescope, has a displacement q in m; theta of its link is that of the link before. Its row of M_theta, f_theta is that for q."""

    def __init__(self, chain):
        self.chain = chain
        self.links, self.joints, self.driven = chain.links, chain.joints, chain.driven
        self.t, self.q, self.qd, self.qdd, self.theta, self.omega = (
            T, chain.q, chain.qd, chain.qdd, chain.theta, chain.omega)
        self.phi = state_symbols("phi", len(chain.rows))
        self.given, self.tau, self.letters = chain.given, chain.tau, chain.letters.all
        self.compact = self._in_letters = compact(chain)
        self.J, self.point_forces = chain.J, chain.point_forces
        self._put = None  # applied to all matrices

    def __repr__(self):
        return f"<Formulas of {', '.join(self.links)} in {', '.join(map(str, self.letters))}>"

    @functools.cached_property
    def notes(self):
        """The matrices of the notes."""
        of = kane(self.chain)
        return apply(self._put, of) if self._put else of

    @functools.cached_property
    def closed(self):
        """The closed form."""
        of = closed(self.chain, self._in_letters)
        return apply(self._put, of) if self._put else of

    def __getattr__(self, name):
        if name.startswith("_") or name in ("notes", "closed"):
            raise AttributeError(name)
        return getattr(self.notes, name)

    @property
    def absolute(self):
        """{theta_i: φ + q_1 + … + q_i, omega_i: likewise} of revolute joints, whose q alone count"""
        chain, sums = self.chain, {}
        for symbols, rates, start in ((self.theta, self.q, chain.phi), (self.omega, self.qd, chain.phid)):
            for i in chain.coordinates.revolute:
                sums[symbols[i]] = start = start + rates[i]
        return sums

    @property
    def acting(self):
        return {symbol: value for force in self.point_forces for symbol, value in force.defined().items()}

    def in_q(self, expression):
        """The expression with q, q̇ and t alone: without theta, omega, functions of time and `acting`."""
        for symbol, value in reversed(list(self.acting.items())):
            expression = expression.xreplace({symbol: value})
        return expression.xreplace(self.absolute).xreplace(self.given)

    def used_letters(self):
        """The letters that are in M, f, J_c or c."""
        of = self.compact
        within = self.tau.free_symbols.union(*(getattr(of, name).free_symbols for name in MATRICES))
        within = within.union(*(value.free_symbols for value in (*self.given.values(), *self.acting.values(), *self.J, *of.coefficients.values())))
        return {symbol: letter for symbol, letter in self.letters.items() if symbol in within}

    def with_numbers(self):
        """A copy in which the scene's numbers stand for the letters."""
        values = self.chain.letters.values()

        def put(expression):
            return tidy_numbers(expression.xreplace(values))

        other = copy.copy(self)
        for name in ("notes", "closed"):
            other.__dict__.pop(name, None)
        other._put = put  # pylint: disable=protected-access
        other.letters = {}
        other.given = {symbol: put(expression) for symbol, expression in self.given.items()}
        other.tau = put(self.tau)
        other.J = [put(J) for J in self.J]
        other.point_forces = [force.applied(put) for force in self.point_forces]
        coefficients = {symbol: put(expression) for symbol, expression in self.compact.coefficients.items()}
        known = {symbol: value for symbol, value in coefficients.items() if value.is_Atom}
        other.compact = types.SimpleNamespace(
            coefficients={symbol: value for symbol, value in coefficients.items() if symbol not in known},
            **{name: tidy_numbers(getattr(self.compact, name).xreplace({**known, **values})) for name in MATRICES})
        return other


def apply(put, matrices):
    """The matrices and lists of matrices with put() applied to each."""
    return types.SimpleNamespace(**{name: [put(one) for one in value] if isinstance(value, list) else put(value)
                                    for name, value in vars(matrices).items()})
