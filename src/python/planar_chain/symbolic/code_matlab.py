"""MATLAB, and Octave: one function, which computes as many of M, f, q̈, A and B as are asked for."""

from sympy.printing.octave import OctaveCodePrinter

from .code import Code, ShortNumbers


class Printer(ShortNumbers, OctaveCodePrinter):
    pass


PRINTER = Printer()


def matlab_code(formulas, name, source, linearize=False):
    """The text of NAME.m."""
    code = Code(PRINTER, formulas, name, source, linearize)
    outputs = ", ".join(code.outputs)
    arguments = "t, q, qd" + ", p" * bool(code.letters) + ", tau" * linearize
    lines = [f"function [{outputs}] = {name}({arguments})", f"% [{outputs}] = {name}({arguments})", "%"]
    lines += [f"% {line}".rstrip() for line in code.header()]
    if code.letters:
        lines += ["%", f"% p: a structure of parameters. Without it, the scene's numbers. p = {name}() returns those."]
    lines += parameters(code)
    if linearize:
        lines += [f"if nargin < {4 + bool(code.letters)}, tau = zeros(1, {code.n}); end  % by default"]
    done = set()
    for k, output in enumerate(code.outputs):
        if k > 0:
            lines += [f"if nargout < {k + 1}, return, end"]
        lines += body(code, output, done)
    return "\n".join(lines + ["end", ""])


def parameters(code):
    """Lines that take the letters from p."""
    if not code.letters:
        return []
    values = [f"  p.{letter.symbol.name} = {letter.value!r};  % {letter.unit}: {letter.meaning}" for letter in code.letters.values()]
    return ["if nargin < 4", *values, "end", f"if nargin == 0, {code.outputs[0]} = p; return, end"]


def body(code, output, done):
    """Lines for one output, without those in `done`, to which they are added."""
    states, letters, _ = code.arguments([output])
    lines = [(symbol.name, f"p.{symbol.name}") for symbol in letters]
    lines += [(symbol.name, f"{array}({i + 1})") for symbol, array, i in states]
    lines += code.statements([output])
    rows = [", ".join(row) for row in code.rows(output)]
    new = [f"{name} = {value};" for name, value in lines if name not in done]
    done.update(name for name, _ in lines)
    return [*new, f"{output} = [{rows[0]}", *(" " * (len(output) + 4) + row for row in rows[1:])][:-1] + [
        (" " * (len(output) + 4) if len(rows) > 1 else f"{output} = [") + rows[-1] + "];"]
