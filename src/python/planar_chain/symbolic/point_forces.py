"""Forces on points of links that depend on the point's place X and velocity v: air drag, and springs to the ground. In components

    drag       F = −c |v| v
    spring     F = −S u,  S = k (L − L⁰) + d L̇,  s = X − ground,  L = |s|,  u = s/L,  L̇ = u·v;  a slack one only where L > L⁰ and S > 0
               without rest length F = −k s − d v

    ∂F/∂v      drag: −c (|v| + v vᵀ/|v|)        spring: −d u uᵀ
    ∂F/∂X      spring: −(S/L + u wᵀ),  w = (k − S/L) u + d (v − L̇ u)/L

Each quantity is a symbol with its definition. Where |v| or L is 0, n is 1 in its place: nothing is divided by 0."""

import dataclasses

import sympy as sp

from .linear import slope

AXES = "xy"


@dataclasses.dataclass
class PointForce:
    """place, velocity: X and v, in terms of x and ẋ of the chain. steps: {symbol: expression} in their order, of what leads to F;
    the first ones, `start`, are X and v. F: symbols. by_place, by_velocity: ∂F/∂X and ∂F/∂v, of symbols that `tangents` defines.
    latex: of all symbols. index: of those."""
    place: sp.Matrix
    velocity: sp.Matrix
    start: dict
    steps: dict
    F: sp.Matrix
    by_place: sp.Matrix
    by_velocity: sp.Matrix
    tangents: dict
    latex: dict
    index: str

    def applied(self, put):
        """The force with put() applied to all expressions."""
        return dataclasses.replace(self, place=put(self.place), velocity=put(self.velocity), **{
            name: {symbol: put(expression) for symbol, expression in getattr(self, name).items()} for name in ("start", "steps", "tangents")})

    def defined(self):
        return {**self.start, **self.steps}

    def gradients(self, x):
        """Of X and v by each x: 2 × n each. Those of v by ẋ are those of X by x."""
        return (sp.Matrix(2, len(x), lambda axis, j, of=of: slope(of[axis], x[j])) for of in (self.place, self.velocity))

    def changes(self, J, W):
        """Of F by each x and by each ẋ, 2 × n each. J, W: gradients()."""
        return self.by_place * J + self.by_velocity * W, self.by_velocity * J


class Steps:
    """Hands out symbols and keeps what they stand for. name, index: of the force, in code and in LaTeX."""

    def __init__(self, name, index):
        self.name, self.index, self.latex, self.all = name, index, {}, {}

    def put(self, name, expression, latex, more=""):
        symbol = sp.Symbol(f"{self.name}_{name}", real=True)
        self.all[symbol], self.latex[symbol] = expression, f"{latex}_{{{self.index}{more}}}"
        return symbol

    def vector(self, name, pair, latex):
        return sp.Matrix([self.put(name + axis, value, latex, "," + axis) for axis, value in zip(AXES, pair)])

    def taken(self):
        """What was put since the last call."""
        all_of_them, self.all = self.all, {}
        return all_of_them

    def derivative(self, matrix, name, by):
        """∂F/∂X or ∂F/∂v: symbols, or 0."""
        return sp.Matrix(2, 2, lambda i, j: matrix[i, j] if matrix[i, j] == 0 else self.put(
            f"dF{AXES[i]}_d{name}{AXES[j]}", matrix[i, j], rf"(\partial F_{AXES[i]}/\partial {by}_{AXES[j]})"))


def nonzero(length):
    return sp.Piecewise((length, length > 0), (1, True))


def drag(c, place, velocity, name, index):
    """c: its coefficient. name, index: of its symbols."""
    steps = Steps(name, index)
    v = steps.vector("v", velocity, "v")
    start = steps.taken()
    speed = steps.put("speed", sp.sqrt(v[0] ** 2 + v[1] ** 2), "|v|")
    F = steps.vector("F", -c * speed * v, "F")
    of_force = steps.taken()
    n = steps.put("n", nonzero(speed), "n")
    by_velocity = steps.derivative(-c * (speed * sp.eye(2) + v * v.T / n), "v", "v")
    return PointForce(place, velocity, start, of_force, F, sp.zeros(2, 2), by_velocity, steps.taken(), steps.latex, index)


def spring(numbers, goes_slack, place, velocity, name, index):
    """numbers: k, d, L⁰ and the point of the ground, in letters."""
    k, d, rest, ground = numbers
    steps = Steps(name, index)
    s, v = steps.vector("s", place - ground, "s"), steps.vector("v", velocity, "v")
    start = steps.taken()
    if rest == 0:
        F = steps.vector("F", -k * s - d * v, "F")
        of_force = steps.taken()
        by_place, by_velocity = (steps.derivative(-number * sp.eye(2), *names) for number, names in ((k, ("s", "s")), (d, ("v", "v"))))
        return PointForce(place, velocity, start, of_force, F, by_place, by_velocity, steps.taken(), steps.latex, index)
    L = steps.put("L", sp.sqrt(s[0] ** 2 + s[1] ** 2), "L")
    n = steps.put("n", nonzero(L), "n")
    u = steps.vector("u", s / n, "u")
    rate = steps.put("rate", u.dot(v), r"\dot{L}")
    pull = steps.put("pull", k * (L - rest) + d * rate, "S")
    is_taut = sp.And(L > rest, pull > 0)
    acting = steps.put("acting", sp.Piecewise((pull, is_taut), (0, True)), "S^+") if goes_slack else pull
    F = steps.vector("F", -acting * u, "F")
    of_force = steps.taken()
    pulls = steps.put("taut", sp.Piecewise((1, is_taut), (0, True)), "h") if goes_slack else 1
    across = steps.put("across", acting / n, "(S/L)")
    w = steps.vector("w", (pulls * k - across) * u + pulls * d * (v - rate * u) / n, "w")
    by_place = steps.derivative(-(across * sp.eye(2) + u * w.T), "s", "s")
    by_velocity = steps.derivative(-pulls * d * u * u.T, "v", "v")
    return PointForce(place, velocity, start, of_force, F, by_place, by_velocity, steps.taken(), steps.latex, index)
