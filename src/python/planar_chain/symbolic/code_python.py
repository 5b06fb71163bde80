"""Python: functions that take the module of mathematics as their first argument, such as numpy."""

import sympy as sp
from sympy.printing.pycode import PythonCodePrinter

from .code import Code, ShortNumbers

WHERE = '''def where(xp, condition, value, otherwise):
    """`value` where the condition holds, by the means of the module."""
    for name in ("if_else", "where"):  # casadi; numpy, jax.numpy
        if hasattr(xp, name):
            return getattr(xp, name)(condition, value, otherwise)
    return value if condition else otherwise  # math


def sign(xp, x):
    return xp.sign(x) if hasattr(xp, "sign") else int(x > 0) - int(x < 0)
'''


class Printer(ShortNumbers, PythonCodePrinter):
    """Functions of the module `xp`. Cases by where(), one condition at a time, as numpy and casadi join them differently."""

    def _print_sin(self, expr):
        return f"xp.sin({self._print(expr.args[0])})"

    def _print_cos(self, expr):
        return f"xp.cos({self._print(expr.args[0])})"

    def _print_Abs(self, expr):
        return f"xp.fabs({self._print(expr.args[0])})"

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
             "xp   the module of mathematics: numpy, sympy or math",
             "Vectors and matrices are returned as lists, such as numpy.array takes."]
    lines += ["p    the parameters, by default those of the scene"] if code.letters else []
    lines += ['"""', ""]
    if code.letters:
        lines += ["SCENE = {", *(f"    {letter.symbol.name!r}: {letter.value!r},  # {letter.unit}: {letter.meaning}"
                                 for letter in code.letters.values()), "}", ""]
    functions = [line for output in code.outputs for line in function(code, output)]
    if any("where(xp" in line or "sign(xp" in line for line in functions):
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
    arguments = "xp, t, q, qd" + (", p=None" if code.letters else "")
    defaults = ["p = SCENE if p is None else p"] if letters else []
    return ["", f"def {output}({arguments}):", *(f"    {line}" for line in defaults + lines), ""]
