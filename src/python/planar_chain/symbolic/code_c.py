"""C99: one function for each of M, f, q̈, A and B. They allocate nothing and keep nothing."""

from sympy.printing.c import C99CodePrinter

from .code import Code, ShortNumbers


class Printer(ShortNumbers, C99CodePrinter):
    pass


PRINTER = Printer()


def c_code(formulas, name, source, linearize=False):
    """The text of a C file. The functions are NAME_M, NAME_f, NAME_qdd, and with `linearize` NAME_A and NAME_B."""
    code = Code(formulas, name, source, linearize)
    lines = ["/*", *(f" * {line}".rstrip() for line in header(code)), " */", "#include <math.h>", ""]
    if code.letters:
        lines += parameters(code)
    lines += [f"void {signature(code, output)};" for output in code.outputs] + [""]
    for output in code.outputs:
        lines += [f"void {signature(code, output)}", "{", *(f"  {line}" for line in body(code, output)), "}", ""]
    return "\n".join(lines)


def header(code):
    n, N = code.n, 2 * code.n
    sizes = {"M": (n, n), "f": (n,), "qdd": (n,), "A": (N, N), "B": (N, n)}
    lines = code.header() + ["", "Arrays: " + ", ".join(
        f"{name}" + "".join(f"[{size}]" for size in sizes[name]) for name in code.outputs) + ". The last argument is written."]
    if code.letters:
        lines += [f"The numbers of the scene are in {code.name}_scene, which may be copied and changed."]
    return lines


def parameters(code):
    """The letters as a structure, and the scene's numbers in it."""
    of = code.letters.values()
    width = max(len(letter.symbol.name) for letter in of)
    return [f"struct {code.name}_parameters {{",
            *(f"  double {letter.symbol.name + ';':{width + 1}} /* {letter.unit}: {letter.meaning} */" for letter in of), "};", "",
            f"extern const struct {code.name}_parameters {code.name}_scene;",
            f"const struct {code.name}_parameters {code.name}_scene = {{",
            *(f"  {letter.value!r},  /* {letter.symbol.name} */" for letter in of), "};", ""]


def signature(code, output):
    """The function's name and arguments."""
    n = code.n
    shape = {"f": f"[{n}]", "qdd": f"[{n}]", "M": f"[{n}][{n}]", "A": f"[{2 * n}][{2 * n}]", "B": f"[{2 * n}][{n}]"}[output]
    given = f"const struct {code.name}_parameters *p, " if code.letters else ""
    return f"{code.name}_{output}({given}double t, const double q[{n}], const double qd[{n}], double {output}{shape})"


def body(code, output):
    states, letters, has_time = code.arguments([output])
    arrays = {array for _, array, _ in states}
    unused = [name for name, is_used in (("p", not code.letters or letters), ("t", has_time), ("q", "q" in arrays),
                                         ("qd", "qd" in arrays)) if not is_used]
    lines = [f"(void){name};" for name in unused]
    lines += [f"const double {symbol.name} = p->{symbol.name};" for symbol in letters]
    lines += [f"const double {symbol.name} = {array}[{i}];" for symbol, array, i in states]
    lines += [f"const double {name} = {PRINTER.on_one_line(expression)};" for name, expression in code.statements([output])]
    matrix = code.program.outputs[output]
    for i in range(matrix.rows):
        for j in range(matrix.cols):
            place = f"[{i}]" if matrix.cols == 1 and output in ("f", "qdd") else f"[{i}][{j}]"
            lines.append(f"{output}{place} = {PRINTER.on_one_line(code.plain(matrix[i, j]))};")
    return lines
