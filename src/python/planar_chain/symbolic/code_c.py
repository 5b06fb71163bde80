"""C99: one function for each of M, f, q̈, A and B. They allocate nothing and keep nothing.

Sines and cosines of angles take most of the time if the C library computes them one by one. So there is a function for all angles,
which compilers turn into instructions for several numbers at once: r = θ − k π with |r| ≤ π/2, and polynomials in r²."""

import re

import mpmath
import sympy as sp
from sympy.printing.c import C99CodePrinter

from .code import NEAR_A_STATE, Code, ShortNumbers


class Printer(ShortNumbers, C99CodePrinter):
    pass


PRINTER = Printer()
FAR = 1e6  # rad: from here on k π is not exact enough, and the C library is called
TERMS = 9  # of the polynomials: their errors are below 4e-18


def polynomial(function):
    """The code of function(z) for 0 ≤ z ≤ (π/2)², in z and zz = z². Even and odd powers are two sums, which take
    less time than one."""
    with mpmath.workdps(40):
        numbers = [sp.Float(str(number), 17) for number in mpmath.chebyfit(function, [0, (mpmath.pi / 2) ** 2], TERMS)]
    even, odd = (sp.horner(sp.Poly(numbers[first::2], sp.Symbol("zz"))) for first in (0, 1))
    return PRINTER.on_one_line(even + sp.Symbol("z") * odd)


def parts_of_pi():
    """π in two parts. The first has 33 bits, so that k times it is exact."""
    first = sp.floor(sp.pi * 2 ** 31) / sp.Integer(2) ** 31
    return [repr(float(part)) for part in (first, sp.pi - first)]


def rotations(n):
    """The function for n angles."""
    first, second = parts_of_pi()
    cosine, sine = polynomial(lambda z: mpmath.cos(mpmath.sqrt(z))), polynomial(lambda z: mpmath.sinc(mpmath.sqrt(z)))
    return f"""\
/* Cosines and sines of all angles, to 3e-16. Those of r = angle - k pi are near-minimax polynomials in z = r^2. Adding and
   subtracting 1.5 * 2^52 rounds to an integer, but not where compilers may reorder sums or sums have more digits than a double. */
#if defined(__FAST_MATH__) || defined(_M_FP_FAST) || FLT_EVAL_METHOD < 0 || FLT_EVAL_METHOD > 1
#define ROUNDS 0
#else
#define ROUNDS 1
#endif
static inline void rotations(const double angle[{n}], double c[{n}], double s[{n}])
{{
  int is_near = ROUNDS;
  for (int i = 0; i < {n}; ++i) is_near &= fabs(angle[i]) < {FAR:g};
  if (!is_near) {{
    for (int i = 0; i < {n}; ++i) {{
      c[i] = cos(angle[i]);
      s[i] = sin(angle[i]);
    }}
    return;
  }}
  for (int i = 0; i < {n}; ++i) {{
    const double shift = 6755399441055744.0;
    const double k = (angle[i] * {float(1 / sp.pi)!r} + shift) - shift;
    const double half_if_odd = 0.5 * k - ((0.5 * k + shift) - shift);
    const double sign = 1 - 8 * half_if_odd * half_if_odd;
    const double r = (angle[i] - k * {first}) - k * {second};
    const double z = r * r, zz = z * z;
    c[i] = sign * ({cosine});
    s[i] = sign * r * ({sine});
  }}
}}
"""


def c_code(formulas, name, source, linearize=False):
    """The text of a C file. The functions are NAME_M, NAME_f, NAME_qdd, and with `linearize` NAME_A and NAME_B."""
    code = Code(PRINTER, formulas, name, source, linearize)
    lines = ["/*", *(f" * {line}".rstrip() for line in header(code)), " */", "#include <float.h>", "#include <math.h>", ""]
    lines += declarations(code)
    if code.letters:
        lines += parameters(code)
    if code.program.angles:
        lines += rotations(len(code.program.angles)).splitlines() + [""]
    for output in code.outputs:
        lines += [f"void {signature(code, output)}", "{", *(f"  {line}" for line in body(code, output)), "}", ""]
    return "\n".join(lines)


def c_header(formulas, name, source, linearize=False):
    """The text of the header of c_code(), for C and C++."""
    code = Code(PRINTER, formulas, name, source, linearize)
    guard = f"{name}_formulas_h"
    cpp = ("#ifdef __cplusplus", 'extern "C" {', "#endif", ""), ("#ifdef __cplusplus", "}", "#endif", "")
    lines = ["/*", *(f" * {line}".rstrip() for line in header(code)), " */", f"#ifndef {guard}", f"#define {guard}", "", *cpp[0]]
    return "\n".join([*lines, *declarations(code), *cpp[1], "#endif", ""])


def declarations(code):
    """The structure of the letters, and the functions."""
    lines = []
    if code.letters:
        of = code.letters.values()
        width = max(len(letter.symbol.name) for letter in of)
        lines += [f"struct {code.name}_parameters {{",
                  *(f"  double {letter.symbol.name + ';':{width + 1}} /* {letter.unit}: {letter.meaning} */" for letter in of), "};", "",
                  f"extern const struct {code.name}_parameters {code.name}_scene;", ""]
    return lines + [f"void {signature(code, output)};" for output in code.outputs] + [""]


def header(code):
    lines = code.header() + ["", "Arrays: " + ", ".join(
        f"{name}" + "".join(f"[{size}]" for size in code.shapes[name]) for name in code.outputs) + ". The last argument is written."]
    if code.letters:
        lines += [f"The numbers of the scene are in {code.name}_scene, which may be copied and changed."]
    return lines


def parameters(code):
    """The scene's numbers in the structure."""
    return [f"const struct {code.name}_parameters {code.name}_scene = {{",
            *(f"  {letter.value!r},  /* {letter.symbol.name} */" for letter in code.letters.values()), "};", ""]


def signature(code, output):
    """The function's name and arguments."""
    n, shape = code.n, "".join(f"[{size}]" for size in code.shapes[output])
    given = f"const struct {code.name}_parameters *p, " if code.letters else ""
    torques = f"const double tau[{n}], " * (output in NEAR_A_STATE)
    return f"{code.name}_{output}({given}double t, const double q[{n}], const double qd[{n}], {torques}double {output}{shape})"


def statements(code, output):
    """Lines for all steps. The first cosine or sine of an angle brings all of them."""
    lines, angles = [], []
    for name, text in code.statements([output]):
        if re.fullmatch(r"(cos|sin)_\d+", name):
            if not angles:
                angles = [code.text(angle) for angle in code.program.angles]
                lines += [f"const double angles[{len(angles)}] = {{{', '.join(angles)}}};",
                          f"double cosines[{len(angles)}], sines[{len(angles)}];", "rotations(angles, cosines, sines);"]
            k = code.program.coordinates.revolute.index(int(name[4:]) - 1)
            lines.append(f"const double {name} = {'cosines' if name[0] == 'c' else 'sines'}[{k}];")
        else:
            lines.append(f"const double {name} = {text};")
    return lines


def body(code, output):
    states, letters, has_time = code.arguments([output])
    arrays = {array for _, array, _ in states}
    unused = [name for name, is_used in (("p", not code.letters or letters), ("t", has_time), ("q", "q" in arrays),
                                         ("qd", "qd" in arrays), ("tau", "tau" in arrays or output not in NEAR_A_STATE)) if not is_used]
    lines = [f"(void){name};" for name in unused]
    lines += [f"const double {symbol.name} = p->{symbol.name};" for symbol in letters]
    lines += [f"const double {symbol.name} = {array}[{i}];" for symbol, array, i in states]
    lines += statements(code, output)
    for i, row in enumerate(code.rows(output)):
        for j, text in enumerate(row):
            place = f"[{i}]" if len(code.shapes[output]) == 1 else f"[{i}][{j}]"
            lines.append(f"{output}{place} = {text};")
    return lines
