#!/usr/bin/python3
"""Lagrange's equations of random chains, differentiated by sympy, evaluated with 40 digits.

Writes equations/chain_N.yaml (the scene) and equations/chain_N.csv (the values); README.md explains them.
Every number of a scene is a multiple of 1/64: the same in decimal, in double and in wider arithmetic.
"""

import pathlib
import random

import mpmath
import sympy

import scene as scenes

FOLDER = pathlib.Path(__file__).parent / "equations"
SIZES = [1, 2, 3, 4, 7]
TIMES = [0.0, 0.5, 1.25, 2.0]  # loads below start and stop exactly at some of them


# ---- Random scenes -------------------------------------------------------------------------------

def dyadic(draw, low, high):
    return draw.randint(round(64 * low), round(64 * high)) / 64


def pair(draw, reach):
    return f"[{dyadic(draw, -reach, reach)}, {dyadic(draw, -reach, reach)}]"


def write_scene(path, n, draw):
    names = [f"body{i + 1}" for i in range(n)]
    lines = [f"# {n} random link{'s' if n > 1 else ''}; made by equations.py",
             f"chain: [{', '.join(names)}]", f"gravity: {pair(draw, 10)}", "links:"]
    for i, name in enumerate(names):
        # One body in the middle is a point mass.
        inertia = 0.0 if i == n // 2 and n > 2 else dyadic(draw, 0.05, 0.5)
        lines += [f"  {name}:",
                  f"    mass: {dyadic(draw, 0.5, 3)}",
                  f"    inertia: {inertia}",
                  f"    com: {pair(draw, 1)}",
                  f"    pin: {pair(draw, 1)}",
                  f"    joint: {{stiffness: {dyadic(draw, 0, 20)}, damping: {dyadic(draw, 0, 2)}, "
                  f"rest_angle: {dyadic(draw, -1, 1)}}}"]
    some = lambda: names[draw.randrange(n)]
    lines += ["loads:",
              f"  at_com:   {{link: {some()}, force: {pair(draw, 5)}}}",
              f"  at_point: {{link: {some()}, force: {pair(draw, 5)}, point: {pair(draw, 2)}, "
              f"moment: {dyadic(draw, -3, 3)}}}",
              f"  all:      {{link: {some()}, joint: {some()}_joint, force: {pair(draw, 5)}, "
              f"point: {pair(draw, 2)}, moment: {dyadic(draw, -3, 3)}, torque: {dyadic(draw, -3, 3)}, "
              f"frequency: {dyadic(draw, 0.25, 2)}, phase: {dyadic(draw, -3, 3)}}}",
              f"  starts:   {{joint: {some()}_joint, torque: {dyadic(draw, 1, 3)}, start: 0.5}}",
              f"  stops:    {{link: {some()}, moment: {dyadic(draw, 1, 3)}, stop: 1.25}}",
              f"  ramp:     {{joint: {some()}_joint, torque: {dyadic(draw, 1, 3)}, times: [0.25, 1, 1.75], "
              f"values: [{dyadic(draw, -2, 2)}, {dyadic(draw, -2, 2)}, {dyadic(draw, -2, 2)}]}}"]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


# ---- Lagrange ------------------------------------------------------------------------------------

def factor(load, t):
    if not load.start <= t < load.stop:
        return mpmath.mpf(0)
    kind, *data = load.law
    if kind == "sine":
        frequency, phase = map(mpmath.mpf, data)
        return mpmath.sin(2 * mpmath.pi * frequency * t + phase)
    if kind == "ramp":
        times, values = ([mpmath.mpf(x) for x in list_] for list_ in data)
        if t <= times[0]:
            return values[0]
        for t0, t1, y0, y1 in zip(times, times[1:], values, values[1:]):
            if t < t1:
                return y0 + (y1 - y0) * (t - t0) / (t1 - t0)
        return values[-1]
    return mpmath.mpf(1)


class Lagrange:
    """M, f_ext and f as functions of q, q̇ and the loads' factors, by symbolic differentiation of
    T(q, q̇), V(q), the dissipation function R(q̇) and the loads' points of attack X(q)."""

    def __init__(self, scene):
        n = len(scene.links)
        q = sympy.symbols(f"q1:{n + 1}")
        v = sympy.symbols(f"v1:{n + 1}")
        factors = sympy.symbols(f"k1:{len(scene.loads) + 1}")
        exact = lambda x: sympy.Rational(x)
        dot = lambda a, b: a[0] * b[0] + a[1] * b[1]
        rate = lambda x: [sum(sympy.diff(c, q[k]) * v[k] for k in range(n)) for c in x]

        def place(i, point):
            """The position of a point of body i, in the ground frame."""
            x = [sympy.Integer(0), sympy.Integer(0)]
            for k in range(i + 1):
                angle = sum(q[:k + 1])
                a, b = map(exact, scene.links[k].pin if k < i else point)
                x = [x[0] + a * sympy.cos(angle) - b * sympy.sin(angle),
                     x[1] + a * sympy.sin(angle) + b * sympy.cos(angle)]
            return x

        T = V = R = 0
        for i, link in enumerate(scene.links):
            com = place(i, link.com)
            T += exact(link.mass) * dot(rate(com), rate(com)) / 2 + exact(link.inertia) * sum(v[:i + 1])**2 / 2
            V -= exact(link.mass) * dot(list(map(exact, scene.gravity)), com)
            V += exact(link.stiffness) * (q[i] - exact(link.rest_angle))**2 / 2
            R += exact(link.damping) * v[i]**2 / 2

        p = [sympy.diff(T, v[i]) for i in range(n)]
        M = [[sympy.diff(p[i], v[j]) for j in range(n)] for i in range(n)]
        f_ext = [-sympy.diff(V, q[i]) - sympy.diff(R, v[i]) for i in range(n)]
        for load, k in zip(scene.loads, factors):
            for i in range(n):
                if load.link is not None:
                    X = place(load.link, load.point)
                    theta = sum(q[:load.link + 1])
                    f_ext[i] += k * dot(list(map(exact, load.force)), [sympy.diff(c, q[i]) for c in X])
                    f_ext[i] += k * exact(load.moment) * sympy.diff(theta, q[i])
                if load.joint == i:
                    f_ext[i] += k * exact(load.torque)
        # d/dt ∂T/∂q̇ − ∂T/∂q = f_ext
        f = [f_ext[i] + sympy.diff(T, q[i]) - sum(sympy.diff(p[i], q[j]) * v[j] for j in range(n))
             for i in range(n)]
        self.evaluate = sympy.lambdify((q, v, factors), (M, f_ext, f), "mpmath", cse=True)


def values(lagrange, scene, q, qd, t, digits):
    with mpmath.workdps(digits):
        factors = [factor(load, mpmath.mpf(t)) for load in scene.loads]
        M, f_ext, f = lagrange.evaluate(list(map(mpmath.mpf, q)), list(map(mpmath.mpf, qd)), factors)
        qdd = mpmath.lu_solve(mpmath.matrix(M), mpmath.matrix(f))
        return ([("M", i, j, M[i][j]) for i in range(len(q)) for j in range(len(q))] +
                [(name, i, 0, x[i]) for name, x in (("f_ext", f_ext), ("f", f), ("qdd", qdd))
                 for i in range(len(q))])


def main():
    FOLDER.mkdir(exist_ok=True)
    for n in SIZES:
        draw = random.Random(n)
        path = FOLDER / f"chain_{n}.yaml"
        write_scene(path, n, draw)
        scene = scenes.read(path)
        lagrange = Lagrange(scene)
        rows = ["t,quantity,row,column,value"]
        for t in TIMES:
            q = [dyadic(draw, -3, 3) for _ in range(n)]
            qd = [dyadic(draw, -4, 4) for _ in range(n)]
            rows += [f"{t},{name},{i},0,{x[i]}" for name, x in (("q", q), ("qd", qd)) for i in range(n)]
            result = values(lagrange, scene, q, qd, t, 40)
            check = values(lagrange, scene, q, qd, t, 60)
            for (name, i, j, x), (*_, y) in zip(result, check):
                assert abs(x - y) <= mpmath.mpf(10)**-30 * (1 + abs(y)), (n, t, name, i, j)
                rows.append(f"{t},{name},{i},{j},{mpmath.nstr(x, 20, strip_zeros=False)}")
        path.with_suffix(".csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
        print(f"{n} links: {len(rows) - 1} values")


if __name__ == "__main__":
    main()
