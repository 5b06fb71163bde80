"""The letters of formulas: a SymPy symbol for each number of a scene that is not zero, with its unit and meaning."""

import dataclasses

import sympy as sp


class NoFormula(ValueError):
    """Raised for a scene, or a part of one, that cannot be written as formulas. Says which, what was expected, and why."""


@dataclasses.dataclass(frozen=True)
class Letter:
    """symbol: its name is that in code. value: the scene's. unit, meaning: words. latex: as it is typeset."""
    symbol: sp.Symbol
    value: float
    unit: str
    meaning: str
    latex: str


def exact(value):
    """A number of the scene as SymPy's: an integer if it is one, else a double."""
    return sp.Integer(int(value)) if value == int(value) and abs(value) < 2 ** 53 else sp.Float(value)


def tidy_numbers(expression):
    """Replaces floating numbers that are integers, such as 1.0, by integers."""
    return expression.xreplace({number: exact(float(number)) for number in expression.atoms(sp.Float)})


def roman(name, *more):
    """A name of the scene as an index in LaTeX, with further indices."""
    return "{" + ",".join([r"\mathrm{" + name.replace("_", r"\_") + "}", *more]) + "}"


class Letters:
    """Hands out letters. A number that is zero has none, so it is in no formula."""

    def __init__(self):
        self.all = {}  # by symbol, in the order of first use

    def number(self, name, value, unit, meaning, latex=None):
        """The letter `name` for this value of the scene; 0 for a zero."""
        if value == 0:
            return sp.Integer(0)
        symbol = sp.Symbol(name)
        self.all[symbol] = Letter(symbol, value, unit, meaning, latex or sp.latex(symbol))
        return symbol

    def vector(self, name, pair, unit, meaning, i, line=True):
        """Two letters for a vector of body i; on its x axis only one, without the index x."""
        x, y = pair
        if y == 0 and line:
            return sp.Matrix([self.number(f"{name}_{i}", x, unit, f"{meaning}, along the x axis of body {i}"), 0])
        return sp.Matrix([self.number(f"{name}_{i}{axis}", value, unit, f"{meaning}, {axis} in the axes of body {i}",
                                      f"{name}_{{{i}{axis}}}") for axis, value in zip("xy", pair)])

    def values(self):
        """{symbol: the scene's number}"""
        return {symbol: exact(letter.value) for symbol, letter in self.all.items()}


def state_symbols(name, n):
    return sp.Matrix([sp.Symbol(f"{name}_{i + 1}", real=True) for i in range(n)])


T = sp.Symbol("t", real=True)
LATEX = {"phi_0": r"\varphi", "phid_0": r"\dot{\varphi}", "phidd_0": r"\ddot{\varphi}", "p_x": "p_x", "p_y": "p_y",
         "pd_x": r"\dot{p}_x", "pd_y": r"\dot{p}_y", "pdd_x": r"\ddot{p}_x", "pdd_y": r"\ddot{p}_y", "xdd_T": r"\ddot{x}_T", "ydd_T": r"\ddot{y}_T"}
DOTTED = {"q": "q", "qd": r"\dot{q}", "qdd": r"\ddot{q}", "beta": r"\ddot{\theta}", "phi": r"\varphi"}


def latex_name(symbol):
    """How a symbol that is no letter of the scene is typeset."""
    name, _, index = symbol.name.rpartition("_")
    if symbol.name in LATEX:
        return LATEX[symbol.name]
    if name in DOTTED:
        return f"{DOTTED[name]}_{{{index}}}"
    if symbol.name.startswith("factor_"):
        return "u_" + roman(symbol.name[len("factor_"):])
    return sp.latex(symbol)
