#!/usr/bin/python3
"""Writes values.h: motions of chains with prismatic links and held tips, by dense equations of Lagrange and scipy's DOP853.

    make.py            needs numpy and scipy

Nothing of this is the program's: with x = (s ..., theta ...) and the places r_j(x) of the centres of mass,

    (sum m_j J_j' J_j + I_j) x'' = sum J_j' (m_j g + F_j - m_j dJ_j/dt x') + joint forces + C' phi,     J_j = dr_j/dx

    C x_tip = c(t): C (J_tip x'' + dJ_tip/dt x') = c''(t), one system with the forces phi of the tip

A base that moves carries the rails. What slides on them is then a point x + i y of which two orders of time are taken:
z_base + exp(i phi) (s d + ...), by products of power series.
"""
import os

import numpy as np
from scipy.integrate import solve_ivp

G = np.array([0.0, -9.81])


def links(chain):
    """(mass, inertia, com, pin, axis or None) of the links."""
    return [(one["mass"], one.get("inertia", 0.0), np.array(one.get("com", [0, 0]), float),
             np.array(one.get("pin", [0, 0]), float),
             None if "axis" not in one else np.array(one["axis"], float) / np.hypot(*one["axis"])) for one in chain]


def times(a, b):
    """The product of two power series of three terms."""
    return np.array([a[0] * b[0], a[0] * b[1] + a[1] * b[0], a[0] * b[2] + a[1] * b[1] + a[2] * b[0]])


def base_of(chain, t):
    """z_base, phi and exp(i phi) as power series around t."""
    x, y, phi = (np.array([law[0], law[1], law[2] / 2]) for law in chain[0].get("base", lambda t: np.zeros((3, 3)))(t))
    turn = np.exp(1j * phi[0]) * np.array([1, 1j * phi[1], 1j * phi[2] - phi[1] ** 2 / 2])
    return x + 1j * y, phi, turn


def two(z):
    return np.array([z.real, z.imag])


def tip_of(chain, t, x, v):
    """Place and velocity of the tip, dx_tip/dx, and its acceleration with x'' = 0."""
    z, _, base = base_of(chain, t)
    J, spun = np.zeros((2, len(chain))), np.zeros((3, 2))
    for j, (_, _, _, pin, axis) in enumerate(links(chain)):
        if axis is not None:
            z = z + times(base, np.array([x[j], v[j], 0]) * complex(*axis)) + base * complex(*pin)
            J[:, j] = two(base[0] * complex(*axis))
            continue
        c, s = np.cos(x[j]), np.sin(x[j])
        arm = np.array([[c, -s], [s, c]]) @ pin
        J[:, j] = [-arm[1], arm[0]]
        spun += np.array([arm, v[j] * J[:, j], -v[j] ** 2 * arm])
    return two(z[0]) + spun[0], two(z[1]) + spun[1], J, two(2 * z[2]) + spun[2]


def acceleration(chain, t, x, v, tip=None):
    M, f = mass_and_forces(chain, t, x, v)
    if tip is None:
        return np.linalg.solve(M, f)
    C = np.array(tip["rows"], float)
    _, _, J, bias = tip_of(chain, t, x, v)
    G, rows = C @ J, len(C)
    whole = np.block([[M, -G.T], [G, np.zeros((rows, rows))]])
    return np.linalg.solve(whole, np.concatenate((f, C @ (tip["acceleration"](t) - bias))))[:len(x)]


def mass_and_forces(chain, t, x, v):
    n = len(chain)
    M, f = np.zeros((n, n)), np.zeros(n)
    place, phi, base = base_of(chain, t)
    J, bias = np.zeros((2, n)), two(2 * place[2])  # of the inner pin
    slides = sum("axis" in one for one in chain)
    for j, (m, inertia, com, pin, axis) in enumerate(links(chain)):
        c, s = np.cos(x[j]), np.sin(x[j])
        turn = np.eye(2) if axis is not None else np.array([[c, -s], [s, c]])
        to_com, to_pin = turn @ com, turn @ pin
        J_com, bias_com = J.copy(), bias.copy()
        if axis is not None:
            along = complex(*axis)
            place = place + times(base, np.array([x[j] * along, v[j] * along, 0]))
            J[:, j] = J_com[:, j] = two(base[0] * along)
            bias_com = two(2 * (place + base * complex(*com))[2])
            place = place + base * complex(*pin)
            bias = two(2 * place[2])
        else:
            J_com[:, j] = [-to_com[1], to_com[0]]
            bias_com = bias - v[j] ** 2 * to_com
            J = J.copy()
            J[:, j] = [-to_pin[1], to_pin[0]]
            bias = bias - v[j] ** 2 * to_pin
            M[j, j] += inertia
        force = chain[j].get("force", lambda t: np.zeros(2))(t)
        M += m * J_com.T @ J_com
        f += J_com.T @ (m * G + force - m * bias_com)
    for i, one in enumerate(chain):
        turns = i > slides
        q, qd = (x[i] - x[i - 1], v[i] - v[i - 1]) if turns else (x[i], v[i])
        if i == slides:
            q, qd = q - phi[0], qd - phi[1]
        tau = -one.get("stiffness", 0) * (q - one.get("rest", 0)) - one.get("damping", 0) * qd
        f[i] += tau
        if turns:
            f[i - 1] -= tau
            if one.get("rotor"):
                M[i, i] += one["rotor"]
                M[i - 1, i - 1] += one["rotor"]
                M[i, i - 1] -= one["rotor"]
                M[i - 1, i] -= one["rotor"]
    return M, f


def run(chain, end, tip=None):
    n = len(chain)
    slides = sum("axis" in one for one in chain)
    q0, v0 = (np.array([one[key] for one in chain], float) for key in ("q", "qd"))
    x0, w0 = q0.copy(), v0.copy()
    turned = [base_of(chain, t)[1] for t in (0, end)]
    x0[slides:] = np.cumsum(q0[slides:]) + turned[0][0]
    w0[slides:] = np.cumsum(v0[slides:]) + turned[0][1]
    if tip is not None:  # the rates of least kinetic energy away that keep the tip
        M, _ = mass_and_forces(chain, 0, x0, w0)
        _, velocity, J, _ = tip_of(chain, 0, x0, w0)
        G = np.array(tip["rows"], float) @ J
        missing = np.array(tip["rows"], float) @ (tip["velocity"] - velocity)
        w0 = w0 + np.linalg.solve(M, G.T @ np.linalg.solve(G @ np.linalg.solve(M, G.T), missing))
    found = solve_ivp(lambda t, y: np.concatenate((y[n:], acceleration(chain, t, y[:n], y[n:], tip))), (0, end),
                      np.concatenate((x0, w0)), method="DOP853", rtol=1e-12, atol=1e-13)
    x, w = found.y[:n, -1], found.y[n:, -1]
    q, qd = x.copy(), w.copy()
    q[slides + 1:], qd[slides + 1:] = np.diff(x[slides:]), np.diff(w[slides:])
    q[slides], qd[slides] = q[slides] - turned[1][0], qd[slides] - turned[1][1]
    return np.concatenate((q, qd))


def sine(t, amplitude, frequency, offset=0):
    w = 2 * np.pi * frequency
    return (offset + amplitude * np.sin(w * t), amplitude * w * np.cos(w * t), -amplitude * w ** 2 * np.sin(w * t))


CART = dict(mass=2.0, pin=[0.0, 0.1], axis=[1, 0], q=0.1, qd=0.2)
POLE = dict(mass=0.5, inertia=0.01, com=[0.4, 0.05], pin=[0.8, 0.0], q=-1.2, qd=0.4)
LOWER = dict(mass=0.3, inertia=0.004, com=[0.2, -0.03], pin=[0.5, 0.1], q=0.7, qd=-1.0)
SCENES = {
    "level": [CART, POLE, LOWER],
    "tilted": [dict(CART, axis=[3, -1], stiffness=30.0, rest=0.2, damping=0.4),
               dict(POLE, damping=0.02), dict(LOWER, stiffness=0.5, damping=0.01)],
    "plane": [dict(CART, stiffness=5.0), dict(mass=0.4, pin=[0.05, 0.0], com=[0.1, 0.1], axis=[0.3, 1], q=-0.2,
                                              qd=0.5, stiffness=40.0, damping=0.3), POLE, LOWER],
    "floating": [dict(mass=0.0, axis=[1, 0], q=0.5, qd=1.0), dict(mass=0.0, axis=[0, 1], q=1.0, qd=4.0), POLE, LOWER],
    "massless": [dict(CART, mass=0.0), POLE, LOWER],
    "turned": [dict(CART, base=lambda t: (sine(t, 0.03, 1.7), sine(t, 0, 1), sine(t, 0.5, 0.4, 0.3)), com=[0.2, -0.1],
                    stiffness=20.0), dict(POLE, damping=0.05), LOWER],
    "turnedPlane": [dict(CART, base=lambda t: (sine(t, 0, 1), sine(t, 0.02, 1.1), sine(t, 0.4, 0.7)), com=[0.1, 0.2],
                         stiffness=30.0), dict(mass=0.4, pin=[0.05, 0.0], com=[0.1, 0.1], axis=[0.3, 1], q=-0.2, qd=0.5,
                                               stiffness=40.0, damping=0.3), POLE, LOWER],
}


def pinned(**more):
    return dict(dict(rows=[[1, 0], [0, 1]], velocity=np.zeros(2), acceleration=lambda t: np.zeros(2)), **more)


TURN = 2 * np.pi * 0.7
CRANK = dict(mass=0.5, inertia=0.01, com=[0.2, 0.05], pin=[0.4, 0.0], q=1.2, qd=3.0)
COUPLER = dict(mass=0.8, inertia=0.05, com=[0.5, 0.1], pin=[1.0, 0.0], q=-1.0, qd=0.0)
ROCKER = dict(mass=0.3, inertia=0.02, com=[0.4, -0.03], pin=[0.8, 0.0], q=-1.5, qd=0.0)
BENT = dict(mass=0.3, inertia=0.004, com=[0.2, -0.03], pin=[0.7, 0.1], q=1.7, qd=0.0)
# Chains whose tip is held where they begin.
HELD = {
    "fourBar": ([dict(CRANK, damping=0.02), COUPLER, dict(ROCKER, stiffness=2.0, damping=0.1)], pinned()),
    "slung": ([dict(CRANK, q=-1.2, qd=1.0, rotor=0.0), dict(COUPLER, q=0.5, rotor=0.1), dict(ROCKER, q=0.5),
               dict(ROCKER, q=0.5)],
              pinned(velocity=np.array([0.2 * TURN, 0]),
                     acceleration=lambda t: np.array([-0.2 * TURN ** 2 * np.sin(TURN * t), 0]))),
    "stiffLoop": ([dict(CRANK, damping=0.1), dict(COUPLER, stiffness=300.0, rest=-1.0, damping=4.0),
                   dict(ROCKER, stiffness=100.0, rest=-1.2), dict(BENT, q=-0.8, damping=0.05)], pinned()),
    "sliderCrank": ([CRANK, COUPLER], dict(pinned(), rows=[[-0.6, 0.8]])),
    "turnedHeldCart": ([dict(CART, base=lambda t: (sine(t, 0.03, 1.1), sine(t, 0, 1), sine(t, 0.2, 0.6, 0.1)), stiffness=20.0,
                             damping=0.3), dict(POLE, q=-1.2), BENT], pinned()),
    "heldCart": ([dict(CART, stiffness=5.0, damping=0.3), dict(POLE, q=-1.2), BENT], pinned()),
}


def main():
    here = os.path.dirname(os.path.abspath(__file__))
    with open(os.path.join(here, "values.h"), "w") as file:
        file.write("#pragma once\n\n/// Written by make.py: q and q̇ of its scenes after 3 s, and where tips are held.\n\n#include <vector>\n\n"
                   "namespace planar_chain::reference {\n\n")
        for name, chain in SCENES.items():
            numbers = ", ".join(f"{value:.15g}" for value in run(chain, 3.0))
            file.write(f"inline const std::vector<double> {name}{{{numbers}}};\n")
        for name, (chain, tip) in HELD.items():
            q = np.array([one["q"] for one in chain], float)
            slides = sum("axis" in one for one in chain)
            q[slides:] = np.cumsum(q[slides:]) + base_of(chain, 0)[1][0]
            for what, values in (("Tip", tip_of(chain, 0, q, 0 * q)[0]), ("", run(chain, 3.0, tip))):
                numbers = ", ".join(f"{value:.17g}" for value in values)
                file.write(f"inline const std::vector<double> {name}{what}{{{numbers}}};\n")
        file.write("\n}  // namespace planar_chain::reference\n")


if __name__ == "__main__":
    main()
