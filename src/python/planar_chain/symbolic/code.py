"""What the printers of C, MATLAB and Python share: functions as lists of lines, and the words of their headers."""

import functools
import math
import re

import sympy as sp
from sympy.codegen.rewriting import create_expand_pow_optimization

from .program import Program

program_of = functools.lru_cache(maxsize=128)(Program)  # several languages may be written of one Formulas

MEANINGS = {
    "M": "mass matrix, kg m^2",
    "f": "right-hand side of M qdd = f, N m; torques of a controller are to be added to it",
    "qdd": "accelerations of the joints, rad/s^2",
    "J_c": "of the tip, which is held: M qdd = f + J_c' phi, J_c qdd = c",
    "c": "of the tip, m/s^2",
    "phi": "forces that hold the tip, along the rows of J_c, N",
    "A": "of dx/dt = A x + B dtau, where x = (dq, dqd) is a small change of the state",
    "B": "columns: additional torque in a joint, N m",
}
class ShortNumbers:
    """For a printer: numbers with as few digits as give the same double."""

    def _print_Float(self, expr):
        return repr(float(expr))

    def on_one_line(self, expression):
        return " ".join(self.doprint(expression).replace("...\n", "").split())  # MATLAB's sign that a line goes on


NEAR_A_STATE = "A", "B"  # outputs whose functions take torques

without_powers = create_expand_pow_optimization(4, base_req=lambda base: True)


RESERVED = set(("break case catch classdef continue else elseif end for function global if otherwise parfor persistent return spmd switch "
                "try while").split())  # by MATLAB; a C function's name has more after it


def name_from(text):
    """An identifier made from the name of a file."""
    name = re.sub(r"\W", "_", text, flags=re.ASCII)
    return name if re.match("[A-Za-z]", name) and name not in RESERVED else "chain_" + name


class Code:
    """One Formulas as code. printer: SymPy's, of the language; name: of the functions; source: words that say where the scene is
    from."""

    def __init__(self, printer, formulas, name, source, linearize):
        self._printer, self._texts = printer, {}
        self.formulas, self.name, self.source = formulas, name, source
        self.program = program_of(formulas, linearize)
        self.n = self.program.n
        self.outputs = list(self.program.outputs)
        self.letters = formulas.used_letters()
        n, k = self.n, self.program.conditions
        self.shapes = {"M": (n, n), "f": (n,), "qdd": (n,), "J_c": (k, n), "c": (k,), "phi": (k,), "A": (2 * n, 2 * n), "B": (2 * n, n)}

    def header(self):
        """Lines of the comment at the top."""
        of, n = self.formulas, self.n
        lines = [f"Equations of motion M(q) qdd = f(t, q, qd) of the scene {self.source}.",
                 "Written by `formulas` of planar_chain; the letters are those of its page of theory.", "",
                 "t    time, s, from 0 on",
                 "q    relative joint angles, rad, counter-clockwise positive; qd their rates, rad/s"]
        if "A" in self.outputs:
            lines += ["tau  torques in the joints, N m, about which A and B are, beside all else that acts"]
        if of.chain.coordinates.prismatic:
            lines += ["     of a prismatic joint: its displacement, m, and m/s; its row of f is a force, N"]
        lines += [f"{name:4} {MEANINGS[name]}" for name in self.outputs]
        lines += ["", f"{n} joint{'s' if n > 1 else ''}, from the ground outwards:"]
        for i, (joint, link) in enumerate(zip(of.joints, of.links)):
            lines.append(f"  {i + 1}  {joint}, of the link {link}" + ", prismatic" * (i in of.chain.coordinates.prismatic)
                         + ", driven: its q and qd must be those of its law" * (i in of.driven))
        if of.driven:
            lines += ["f of a driven joint contains the torque that its drive gives."]
        if of.tau.has(sp.sign):
            lines += ["Friction is that of joints that move. At qd = 0 it is 0 here: no formula describes joints that stick."]
        return lines

    def statements(self, names):
        """(name, text) of all steps that these outputs need."""
        return [(symbol.name, self.text(expression)) for symbol, expression in self.program.needed(*names)]

    def text(self, expression):
        """The expression as code, with powers as products, and π as a number. Several outputs may need one step."""
        if expression not in self._texts:
            plain = without_powers(expression.xreplace({sp.pi: sp.Float(math.pi)})) if not expression.is_Atom else expression
            self._texts[expression] = self._printer.on_one_line(plain)
        return self._texts[expression]

    def rows(self, output):
        """The entries of a matrix of outputs as code, row by row."""
        return [[self.text(entry) for entry in row] for row in self.program.outputs[output].tolist()]

    def arguments(self, names):
        """(symbol, array, index) of the states and torques that the outputs need, the letters that they need, and whether they need t."""
        needed = self.program.needed(*names)
        within = set().union(*(e.free_symbols for _, e in needed), *(self.program.outputs[name].free_symbols for name in names))
        states = [(symbol, array, i) for array, symbols in (("q", self.formulas.q), ("qd", self.formulas.qd), ("tau", self.program.added))
                  for i, symbol in enumerate(symbols) if symbol in within]
        return states, [symbol for symbol in self.letters if symbol in within], self.formulas.t in within
