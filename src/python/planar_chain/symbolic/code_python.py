"""Python: functions that take the module of mathematics as their first argument, such as numpy."""

import sympy as sp
from sympy.printing.pycode import PythonCodePrinter

from .code import NEAR_A_STATE, Code, ShortNumbers

WHERE = '''def where(xp, condition, value, otherwise):
    """`value` where the condition holds, by the means of the module."""
    for name in ("if_else", "where"):  # casadi; numpy, jax.numpy
        if hasattr(xp, name):
            return getattr(xp, name)(condition, value, otherwise)
    if hasattr(xp, "Piecewise"):  # sympy
        return xp.Piecewise((value, condition), (otherwise, True))
    return value if condition else otherwise  # math


def sign(xp, x):
    return xp.sign(x) if hasattr(xp, "sign") else int(x > 0) - int(x < 0)


def size(xp, x):
    return xp.fabs(x) if hasattr(xp, "fabs") else abs(x)
'''


class Printer(ShortNumbers, PythonCodePrinter):
    """Functions of the module `xp`. Cases by where(), one condition at a time, as numpy and casadi join them differently."""

    def _print_sin(self, expr):
        return f"xp.sin({self._print(expr.args[0])})"

    def _print_cos(self, expr):
        return f"xp.cos({self._print(expr.args[0])})"

    def _print_Abs(self, expr):
        return f"size(xp, {self._print(expr.args[0])})"

    def _print_Pow(self, expr, rational=False):
        if expr.exp == sp.Rational(1, 2):
            return f"xp.sqrt({self._print(expr.base)})"
        return super()._print_Pow(expr, rational)

    def _print_sign(self, expr):
        return f"sign(xp, {self._print(expr.args[0])})"

    def _print_Piecewise(self, expr):
        text = self._print(expr.args[-1].expr)
        for value, condition in reversed(expr.args[:-1]):
            parts = condition.args if isinstance(condition, sp.And) else [condition]
            inner = self._print(value)
            for part in reversed(parts):
                inner = f"where(xp, {self._print(part)}, {inner}, {text})"
            text = inner
        return text


PRINTER = Printer()


def python_code(formulas, name, source, linearize=False):
    """The text of a module with functions M, f, qdd, and with `linearize` A and B."""
    code = Code(PRINTER, formulas, name, source, linearize)
    lines = ['"""' + code.header()[0], *code.header()[1:], "",
             "xp   the module of mathematics: numpy, math, sympy, jax.numpy or casadi",
             "Vectors and matrices are returned as lists, such as numpy.array takes."]
    lines += ["p    the parameters, by default those of the scene"] if code.letters else []
    lines += ['"""', ""]
    if code.letters:
        lines += ["SCENE = {", *(f"    {letter.symbol.name!r}: {letter.value!r},  # {letter.unit}: {letter.meaning}"
                                 for letter in code.letters.values()), "}", ""]
    functions = [line for output in code.outputs for line in function(code, output)]
    if any(name + "(xp" in line for line in functions for name in ("where", "sign", "size")):
        lines += ["", *WHERE.splitlines(), ""]
    return "\n".join(lines + functions).rstrip() + "\n"


def function(code, output):
    states, letters, _ = code.arguments([output])
    lines = [f"{symbol.name} = p[{symbol.name!r}]" for symbol in letters]
    lines += [f"{symbol.name} = {array}[{i}]" for symbol, array, i in states]
    lines += [f"{name} = {text}" for name, text in code.statements([output])]
    rows = [", ".join(row) for row in code.rows(output)]
    if len(code.shapes[output]) == 1:
        lines.append(f"return [{', '.join(rows)}]")
    else:
        lines += ["return [", *(f"    [{row}]," for row in rows), "]"]
    arguments = "xp, t, q, qd" + ", p=None" * bool(code.letters) + ", tau=None" * (output in NEAR_A_STATE)
    defaults = ["p = SCENE if p is None else p"] if letters else []
    defaults += [f"tau = [0] * {code.n} if tau is None else tau"] * any(array == "tau" for _, array, _ in states)
    return ["", f"def {output}({arguments}):", *(f"    {line}" for line in defaults + lines), ""]
