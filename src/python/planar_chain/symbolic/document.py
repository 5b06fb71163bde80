"""LaTeX: a document with the letters, every step of the notes, and M and f."""

import sympy as sp
from sympy.printing.latex import LatexPrinter

from .letters import latex_name
from .linear import linear

WIDEST = 75  # letters in a line
WIDEST_MATRIX = 105  # wider ones are printed entry by entry

PREAMBLE = r"""\documentclass[a4paper]{article}
\usepackage[margin=22mm]{geometry}
\usepackage[utf8]{inputenc}
\usepackage{amsmath,graphicx,longtable}
\allowdisplaybreaks
\setcounter{MaxMatrixCols}{20}
\begin{document}
"""

RULES = r"""\begin{align*}
B_{ij} &= S_r^i S_{i0}\ (i = j),\quad S_p^i S_{i0}\ (i < j), & C_{ij} &= S_r^i [\omega^i] S_{i0}\ (i = j),\quad
S_p^i [\omega^i] S_{i0}\ (i < j)\\
V_{pd} &= T B,\quad W_{pd} = T, & A_1 &= T C\,\mathrm{diag}(m_1, m_1, m_2, m_2, \ldots)\\
A_2 &= T B\,\mathrm{diag}(m_1, m_1, m_2, m_2, \ldots), & A_3 &= T\,\mathrm{diag}(I_1, I_2, \ldots)\\
f_{ext} &= V_{pd} F + W_{pd} M_{ext} + \tau, & f &= f_{ext} - V_{pd} A_1^T \dot{q}\\
M &= V_{pd} A_2^T + W_{pd} A_3^T
\end{align*}
"""

NEAR_A_STATE = r"""Small changes $x = (\delta q, \delta\dot{q})$ of a state, and additional torques $\delta\tau$ in the joints, give
\begin{align*}
\dot{x} &= A x + B\,\delta\tau, & A &= \begin{bmatrix} 0 & 1\\ M^{-1} K & M^{-1} D \end{bmatrix}, &
B &= \begin{bmatrix} 0\\ M^{-1} \end{bmatrix}\\
K &= T K_\theta T^T + K_\tau, & D &= T D_\theta T^T + D_\tau
\end{align*}
$\ddot{\theta}_i$ are the sums of the accelerations $\ddot{q}$ at the state, under the torques $\tau^*$ about which $A$ and $B$ are:
$M \ddot{q} = f + \tau^*$. """

CLOSED = r"""The tip is held along the unit vectors $c_j$, by forces $\varphi_j$:
\begin{align*}
\begin{bmatrix} M & J_c^T\\ J_c & 0 \end{bmatrix} \begin{bmatrix} \ddot{q}\\ -\varphi \end{bmatrix} &=
\begin{bmatrix} f\\ c \end{bmatrix}
\end{align*}
"""

CLOSED_NEAR_A_STATE = r"""Small changes $x = (\delta q, \delta\dot{q})$ of a state, and additional torques $\delta\tau$ in the joints, give
$\dot{x} = A x + B\,\delta\tau$, where $\delta\ddot{q}$, the lower rows, follows from
\begin{align*}
\begin{bmatrix} M & J_c^T\\ J_c & 0 \end{bmatrix} \begin{bmatrix} \delta\ddot{q}\\ -\delta\varphi \end{bmatrix} &=
\begin{bmatrix} K\,\delta q + D\,\delta\dot{q} + \delta\tau\\ K_c T^T \delta q + D_c T^T \delta\dot{q} \end{bmatrix}\\
K &= T K_\theta T^T + K_\tau, \quad D = T D_\theta T^T + D_\tau
\end{align*}
$\ddot{\theta}_i$ are the sums of the accelerations $\ddot{q}$, and $\varphi$ the forces on the tip, at the state, under the torques $\tau^*$
about which $A$ and $B$ are: $M \ddot{q} = f + \tau^* + J_c^T \varphi$. """


POINTS = r""" A force on a point, of air drag or a spring to the ground, adds
$G^T (\partial F/\partial s\,G + \partial F/\partial v\,W)$ to $K_\theta$ and $G^T \partial F/\partial v\,G$ to $D_\theta$. $G$ and $W$ are
the derivatives of the point's place and velocity by $\theta_i$. """


def as_text(words):
    """Words of a scene as LaTeX's text."""
    for character, command in (("\\", r"\textbackslash "), ("_", r"\_"), ("%", r"\%"), ("&", r"\&"), ("#", r"\#"), ("$", r"\$"),
                               ("{", r"\{"), ("}", r"\}"), ("~", r"\textasciitilde "), ("^", r"\textasciicircum ")):
        words = words.replace(character, command)
    return words


FACTORS = ("m", "I", "J", "g", "p", "r")  # the first letters of a product; states and functions are its last


def place(factor):
    """Where a factor of a product stands, as textbooks write it: 2 m_2 p_1 r_2 ω_1² sin θ_2."""
    base = factor.as_base_exp()[0]
    if base.is_number:
        return -1
    if base.is_Symbol:
        name = base.name.partition("_")[0]
        return FACTORS.index(name) if name in FACTORS else len(FACTORS) + (2 if name in ("t", "q", "qd", "omega", "beta", "phi") else 0)
    return len(FACTORS) + (1 if base.is_Add else 3)


class Printer(LatexPrinter):
    """Numbers with six digits. Products in the order of textbooks."""

    def _print_Mul(self, expr):
        if expr.could_extract_minus_sign() and (-expr).is_Mul:
            return "- " + self._print_Mul(-expr)
        if expr.could_extract_minus_sign() or sp.fraction(expr, exact=True)[1] != 1:
            return super()._print_Mul(expr)
        factors = sorted(expr.as_ordered_factors(), key=place)
        last = len(factors) - 1
        texts = [self._print(factor) for factor in factors]
        return " ".join(rf"\left({text}\right)" if self._needs_mul_brackets(factor, first=k == 0, last=k == last) else text
                        for k, (factor, text) in enumerate(zip(factors, texts)))

    def _print_Float(self, expr):
        text = f"{float(expr):.6g}"
        mantissa, _, exponent = text.partition("e")
        return mantissa + (rf" \cdot 10^{{{int(exponent)}}}" if exponent else "")


class Document:
    """One Formulas as a LaTeX document. picture: the name of a picture of the chain, or None. linearize: whether with A and B."""

    def __init__(self, formulas, source, picture=None, linearize=False):
        self.of, self.source, self.picture, self.n = formulas, source, picture, len(formulas.q)
        self.linear = linear(formulas) if linearize else None
        known = {symbol: letter.latex for symbol, letter in formulas.letters.items()}
        symbols = set().union(*(e.free_symbols for e in formulas.given.values()), formulas.given, formulas.q, formulas.qd, formulas.qdd,
                              formulas.closed.f_theta.free_symbols, formulas.tau.free_symbols,
                              formulas.closed.c.free_symbols, formulas.phi, self.linear.beta if linearize else [])
        for force in formulas.point_forces:
            known.update(force.latex)
            symbols |= set().union(*(e.free_symbols for e in force.defined().values()))
        known.update({symbol: latex_name(symbol) for symbol in symbols if symbol.is_Symbol and symbol not in known})
        self.printer = Printer({"symbol_names": known, "fold_short_frac": True, "fold_func_brackets": True,
                                "mat_str": "matrix"})

    def tex(self, expression):
        return self.printer.doprint(expression)

    def text(self):
        parts = [PREAMBLE, self._title(), self._letters(), self._angles(), self._steps(), self._relative(), self._absolute(),
                 self._near_a_state() if self.linear else "", r"\end{document}"]
        return "\n".join(part for part in parts if part) + "\n"

    # ---- Pieces ----------------------------------------------------------------------------------

    def equation(self, left, expression, relation="="):
        """Lines of an align environment, broken between terms where the right side is long."""
        terms = expression.as_ordered_terms() if isinstance(expression, sp.Add) else [expression]
        return left + " &" + relation + " " + self.broken([(self.tex(term), self._width(term)) for term in terms])

    @staticmethod
    def broken(terms):
        """A sum of terms (text, width), on several lines if it is long."""
        lines, width = [""], 0
        for k, (text, size) in enumerate(terms):
            text = text if k == 0 or text.startswith("-") else "+ " + text
            if width and width + size > WIDEST:
                lines.append(r"&\quad ")
                width = 0
            lines[-1] += text + " "
            width += size
        return "\\\\\n".join(lines)

    @staticmethod
    def _width(term):
        """About how many letters wide a term is."""
        return len(str(term).replace("omega", "w").replace("theta", "o").replace("_", "").replace("*", ""))

    def block(self, equations):
        return "\\begin{align*}\n" + "\\\\\n".join(equations) + "\n\\end{align*}\n" if equations else ""

    def matrix(self, name, value):
        """Lines: the matrix as a whole, or if that is too wide its entries that are not zero. A zero matrix: none."""
        if all(entry == 0 for entry in value):
            return []
        if sum(max(self._width(entry) for entry in value.col(j)) + 2 for j in range(value.cols)) <= WIDEST_MATRIX:
            return [f"{name} &= {self.tex(value)}"]
        index = (lambda i, j: f"{i + 1}") if value.cols == 1 else (lambda i, j: f"{i + 1},{j + 1}")
        name = f"({name})" if "_" in name else name
        return [self.equation(f"{name}_{{{index(i, j)}}}", value[i, j]) for i in range(value.rows) for j in range(value.cols)
                if value[i, j] != 0]

    def _title(self):
        picture = ""
        if self.picture:
            picture = f"\\begin{{center}}\\includegraphics[width=\\textwidth,height=75mm,keepaspectratio]{{{self.picture}}}\\end{{center}}\n"
        joints = ", ".join(f"{i} {as_text(joint)}" for i, joint in enumerate(self.of.joints, 1))
        return (f"\\section*{{Equations of motion of {as_text(self.source)}}}\n"
                "Kane's method for pin-connected rigid bodies in the plane, in the letters of planar\\_chain's page of theory. "
                f"Joints from the ground outwards: {joints}. A number that is zero in the scene has no letter.\n" + picture)

    def _letters(self):
        rows = [f"${letter.latex}$ & {as_text(letter.meaning)} & {letter.value:.6g} & {letter.unit.replace('^2', '$^2$')} \\\\"
                for letter in self.of.used_letters().values()]
        displacements = [rf"$q_{{{i + 1}}}$, $\dot{{q}}_{{{i + 1}}}$, $\ddot{{q}}_{{{i + 1}}}$ & displacement of the prismatic joint {i + 1} "
                         rf"({as_text(self.of.joints[i])}) along its axis, its rate and acceleration & & m, m/s, m/s$^2$ \\"
                         for i in self.of.chain.coordinates.prismatic]
        states = [r"$q_i$, $\dot{q}_i$, $\ddot{q}_i$ & relative angle of joint $i$, its rate and acceleration & & "
                  r"rad, rad/s, rad/s$^2$ \\",
                  r"$\theta_i$, $\omega_i$ & absolute angle and angular velocity of body $i$ & & rad, rad/s \\"]
        if self.of.chain.rows:
            states.append(r"$\varphi_j$ & force on the tip along the unit vector $c_j$ & & N \\")
        return ("\\subsection*{Letters}\n\\begin{longtable}{lp{85mm}rl}\n" + "\n".join(states + displacements + rows) + "\n\\end{longtable}\n")

    def _angles(self):
        lines = [self.equation(self.tex(symbol), value) for symbol, value in self.of.absolute.items()]
        lines += [self.equation(self.tex(symbol), value) for symbol, value in self.of.given.items()]
        return "\\subsection*{Angles and given motions}\n" + self.block(lines) + self._point_forces()

    def _point_forces(self):
        if not self.of.point_forces:
            return ""
        return ("\\subsection*{Air drag and springs to the ground}\nEach with the velocity $v$ of its point, the vector $s$ from the ground to it, "
                "and the force $F$ on the link.\n" + "\n".join(self.block([self.equation(self.tex(symbol), value)
                                                                     for symbol, value in force.defined().items()])
                                                         for force in self.of.point_forces))

    def _steps(self):
        """The matrices of the notes."""
        of = self.of.notes
        rotations = [f"S_{{{i}0}} &= {self.tex(S)}" for i, S in enumerate(of.S, 1)]
        names = (("T", of.T), ("V_{pd}", of.V_pd), ("A_1", of.A_1), ("A_2", of.A_2), ("A_3", of.A_3), ("F", of.F),
                 ("M_{ext}", of.M_ext), (r"\tau", self.of.tau), ("f_{ext}", of.f_ext))
        blocks = [self.block(rotations), RULES] + [self.block(self.matrix(*named)) for named in names]
        return "\\subsection*{The steps of the notes}\n" + "\n".join(blocks) + self._remarks()

    def _remarks(self):
        remarks = []
        coordinates = self.of.chain.coordinates
        if coordinates.prismatic:
            remarks.append(r"A prismatic joint $i$ has the row $T_{ij} = 0$. Instead, $V_{pd}$ has the direction of its axis $d_i$ "
                           r"in row $i$ at all bodies $j \ge i$, and $A_2 = V_{pd}\,\mathrm{diag}(m_1, m_1, \ldots)$.")
        if any(self.of.chain.omega[i] != 0 for i in coordinates.prismatic):
            remarks.append(r"In $S_r^i$ and $S_p^i$ of its body, $q_i d_i$ is added to $r^i$ and $p^i$. As the body turns, "
                           r"$2 \omega_i \dot{q}_i\, \hat{k} \times d_i$ is added to the accelerations of the bodies $j \ge i$.")
        if any(J != 0 for J in self.of.chain.J):
            remarks.append(r"The rotors' inertias $J_i$ are added to the diagonal of $M$.")
        if self.of.chain.phidd != 0 or any(x != 0 for x in self.of.chain.pdd):
            remarks.append(r"As the base moves, $f = f_{ext} - V_{pd}\, \mathrm{diag}(m) (C^T \omega + B^T 1 \ddot{\varphi} + "
                           r"\ddot{p}) - W_{pd} I \ddot{\varphi}$.")
        if self.of.driven:
            remarks.append(r"$\tau_j$ of a driven joint is the torque of its drive. It follows from row $j$ of $M \ddot{q} = f$.")
        if self.of.tau.has(sp.sign):
            remarks.append("Friction is that of joints that move. No formula describes joints that stick.")
        return " ".join(remarks) + "\n"

    def _torque(self, i):
        """The letter τ_i, or 0 where no torque acts."""
        return sp.Integer(0) if self.of.tau[i] == 0 else sp.Symbol(f"tau_{i + 1}")

    def _in_brackets(self, factor):
        return rf"\left({self.tex(factor)}\right)" if factor.is_Add else self.tex(factor)

    def _relative(self):
        """M q̈ = f, entry by entry, M in terms of q."""
        n, of = self.n, self.of
        coordinates = of.chain.coordinates
        revolute = coordinates.revolute
        in_q = {of.theta[i]: sp.Add(*(of.q[k] for k in revolute if k <= i)) for i in revolute}
        M = [self.equation(f"M_{{{i + 1}{',' * (n > 9)}{j + 1}}}", of.closed.M[i, j].xreplace(in_q)) for i in range(n)
             for j in range(i, n) if of.closed.M[i, j] != 0]
        f = [self.equation(f"f_{{{i + 1}}}", self._torque(i) + sp.Add(*(of.closed.loads_theta[k] for k in coordinates.outwards(i))))
             for i in range(n)]
        of_base, sums = "" if of.chain.phi == 0 else self.tex(of.chain.phi) + " + ", ""
        if revolute:
            terms = (rf"q_{{{revolute[0] + 1}}} + \dots + q_i" if revolute == list(range(revolute[0], n)) else
                     r"\sum q_j$ of the revolute joints $j \le i")
            sums = rf"$\theta_i = {of_base}{terms}$ is the absolute angle of body $i$, $\omega_i$ its rate." + "\n"
        return "\\subsection*{$M \\ddot{q} = f$, a row for each joint}\n" + sums + self.block(M) + self.block(f) + self._tip()

    def _tip(self):
        """J_c and c of a tip that is held."""
        of, chain = self.of.closed, self.of.chain
        if not chain.rows:
            return ""
        rows = [f"c_{j} &= {self.tex(row.T)}" for j, row in enumerate(chain.rows, 1)]
        J_c = [self.equation(f"(J_c)_{{{j + 1},{i + 1}}}", of.J_c[j, i]) for j in range(len(chain.rows)) for i in range(self.n)]
        c = [self.equation(f"(c)_{{{j + 1}}}", value) for j, value in enumerate(of.c)]
        return CLOSED + self.block(rows) + self.block(J_c) + self.block(c)

    def _absolute(self):
        """One equation for each body, as textbooks print them."""
        of, rows, coordinates = self.of.closed, [], self.of.chain.coordinates
        for i in range(self.n):
            inertia = [(j, of.M_theta[i, j]) for j in range(self.n) if of.M_theta[i, j] != 0]
            terms = [(rf"{self._in_brackets(m)} \ddot{{{'q' if j in coordinates.prismatic else chr(92) + 'theta'}}}_{{{j + 1}}}",
                      self._width(m) + 4) for j, m in inertia]
            rows.append(" &" + self.broken(terms))
            on_tip = (of.J_theta[j, i] * self.of.phi[j] for j in range(len(self.of.phi)))
            of_next = (-self._torque(j) for j, k in enumerate(coordinates.inner) if k == i)
            rows.append(self.equation("", sp.Add(of.loads_theta[i], self._torque(i), *of_next, *on_tip), r"\qquad = "))
        against = r" $\ddot{\theta}_i$ is relative to the base." if self.of.chain.phidd != 0 else ""
        return f"\\subsection*{{The same in absolute angles}}\nOne equation for each body.{against}\n" + self.block(rows)

    def _near_a_state(self):
        """A and B, by the matrices that they are made of."""
        of = self.linear
        remark = ("Of $M$, $K$ and $D$ take the rows and columns of free joints, and of $K$ and $D$ all columns; "
                  r"$\delta\ddot{q}$ of a driven joint is 0." if self.of.driven else "")
        if self.of.chain.coordinates.prismatic:
            remark += (r" Of a prismatic joint $i$, $q_i$ takes the place of $\theta_i$; row and column $i$ of $T$ are here those of the "
                       "unit matrix.")
        blocks = [self.block(self.matrix(*named)) for named in ((r"K_\theta", of.K_theta), (r"D_\theta", of.D_theta),
                                                                (r"K_\tau", of.K_tau), (r"D_\tau", of.D_tau),
                                                                ("K_c", of.K_c), ("D_c", of.D_c))]
        if of.points:
            remark += POINTS
        for force, pair in zip(self.of.point_forces, of.points):
            blocks += [self.block(self.matrix(f"{name}_{{{force.index}}}", value)) for name, value in zip("GW", pair)]
            blocks += [self.block([self.equation(self.tex(symbol), value) for symbol, value in force.tangents.items()])]
        rules = CLOSED_NEAR_A_STATE if self.of.chain.rows else NEAR_A_STATE
        return "\n".join(["\\subsection*{Near a state}", rules + remark.lstrip(), *blocks, "A matrix that is not printed is zero.\n"])
