"""Laws of time as expressions: sines, splines and ramps of the base, of driven joints and of loads.

Tables of times and values stay numbers, also where other numbers of the scene are letters."""

import numpy as np
import sympy as sp

from .letters import T, NoFormula, exact, roman

MOST_KNOTS = 100


def require_few(path, times):
    if len(times) > MOST_KNOTS:
        raise NoFormula(f"{path}: expected at most {MOST_KNOTS} times and values, got {len(times)}: a longer table is no formula")


def pieces(times, polynomials, before, after):
    """The polynomial k, of t − times[k], from times[k] on."""
    parts = [(before, T < exact(times[0]))]
    parts += [(polynomial, T < exact(end)) for polynomial, end in zip(polynomials, times[1:])]
    return sp.Piecewise(*parts, (after, True))


def spline_rates(times, values):
    """The rates at the knots of the cubic spline with continuous acceleration, and rate 0 at both ends (motion_law.cpp)."""
    h, last = np.diff(times), len(times) - 1
    slope = np.diff(values) / h
    matrix, right = np.eye(last + 1), np.zeros(last + 1)
    for i in range(1, last):
        matrix[i, i - 1:i + 2] = 1 / h[i - 1], 2 * (1 / h[i - 1] + 1 / h[i]), 1 / h[i]
        right[i] = 3 * (slope[i - 1] / h[i - 1] + slope[i] / h[i])
    return np.linalg.solve(matrix, right)


def spline(times, values):
    """The value, rate and acceleration in time."""
    h, rate = np.diff(times), spline_rates(times, values)
    polynomials = []
    for i, length in enumerate(h):
        m = (values[i + 1] - values[i]) / length
        c = (values[i], rate[i], (3 * m - 2 * rate[i] - rate[i + 1]) / length,
             (rate[i] + rate[i + 1] - 2 * m) / length ** 2)
        s = T - exact(times[i])
        polynomials.append(sum(exact(c[k]) * s ** k for k in range(4)))
    ends = exact(values[0]), exact(values[-1])
    return [pieces(times, [sp.diff(p, T, k) for p in polynomials], *(ends if k == 0 else (0, 0))) for k in range(3)]


def motion(letters, path, law, name, latex, unit):
    """The value, rate and acceleration of a MotionLaw. name, latex: of its letters."""
    if "times" in law:
        require_few(path, law["times"])
        return spline(law["times"], law["values"])

    def letter(key, sign, its_unit):
        return letters.number(f"{name}_{key}", law[key], its_unit, f"{key} of {path}", f"{sign}_{latex}")

    amplitude, frequency = letter("amplitude", "A", unit), letter("frequency", r"\nu", "Hz")
    x = letter("offset", "b", unit) + amplitude * sp.sin(2 * sp.pi * frequency * T + letter("phase", r"\psi", "rad"))
    return [x, sp.diff(x, T), sp.diff(x, T, 2)]


def factor(letters, name, load):
    """The factor of a load in time."""
    path = f"loads/{name}"

    def letter(key, sign, unit):
        return letters.number(f"load_{name}_{key}", load[key], unit, f"{key} of the load {name}", f"{sign}_{roman(name)}")

    value = sp.Integer(1)
    if "frequency" in load:
        value = sp.sin(2 * sp.pi * letter("frequency", r"\nu", "Hz") * T + letter("phase", r"\psi", "rad"))
    if "times" in load:
        times, values = load["times"], load["values"]
        require_few(path, times)
        lines = [exact(a) + exact((b - a) / (t1 - t0)) * (T - exact(t0))
                 for t0, t1, a, b in zip(times, times[1:], values, values[1:])]
        value = pieces(times, lines, exact(values[0]), exact(values[-1]))
    parts = []
    if load["start"] > 0:
        parts.append((0, T < letter("start", "t^0", "s")))
    if load["stop"] is not None:
        parts += [(value, T < letter("stop", "t^1", "s")), (0, True)]
    else:
        parts.append((value, True))
    return sp.Piecewise(*parts)
