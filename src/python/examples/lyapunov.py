#!/usr/bin/python3
"""Largest Lyapunov exponents of a hundred double pendulums, from A of ẋ = A x along each motion.

    lyapunov.py [SCENES [SECONDS [PICTURE]]]      default 100 60 lyapunov.png

A small deviation follows δ̇ = A(t) δ, here by the Runge–Kutta method of order 4. The exponent is the mean growth of
log |δ|, 1/s. It is near 0 for a regular motion and positive for a chaotic one. Masses, lengths and starts are random."""
import sys
import warnings

import numpy as np
from planar_chain import Scene, Simulation

STEP = 0.005  # s
warnings.filterwarnings("ignore", "this state is no equilibrium")  # each motion starts at rest


def growth(scene, seconds, delta):
    """Returns log |δ| at the end less that at the start, and the direction of δ at the end. delta: 2n, at the start."""
    simulation = Simulation(scene)
    total, A_0 = 0.0, simulation.linearize()[0]
    delta = delta / np.linalg.norm(delta)
    for k in range(round(seconds / STEP)):
        simulation.advance_to((k + 0.5) * STEP)
        A_half = simulation.linearize()[0]
        simulation.advance_to((k + 1) * STEP)
        A_1 = simulation.linearize()[0]
        a = A_0 @ delta
        b = A_half @ (delta + STEP / 2 * a)
        c = A_half @ (delta + STEP / 2 * b)
        d = A_1 @ (delta + STEP * c)
        delta = delta + STEP / 6 * (a + 2 * b + 2 * c + d)
        size = np.linalg.norm(delta)
        total, delta, A_0 = total + np.log(size), delta / size, A_1
    return total, delta


def random_scene(random):
    """Two uniform rods, at rest at any angles."""
    links = {}
    for name in ("upper", "lower"):
        mass, length, angle = random.uniform(0.5, 2), random.uniform(0.5, 1.5), random.uniform(-np.pi, np.pi)
        links[name] = {"mass": mass, "inertia": mass * length ** 2 / 12, "com": [length / 2, 0], "pin": [length, 0],
                       "initial": {"angle": angle}}
    return Scene({"chain": list(links), "links": links})


def energy_above_rest(scene):
    """As a share of the energy at rest, hanging."""
    simulation = Simulation(scene)
    energy = simulation.energy_balance().now.total
    simulation.settle()
    rest = simulation.energy_balance().now.total
    return (energy - rest) / abs(rest)


def main():
    scenes, seconds, picture = sys.argv[1:] + ["100", "60", "lyapunov.png"][len(sys.argv) - 1:]
    random, found = np.random.default_rng(4), []
    for k in range(int(scenes)):
        scene = random_scene(random)
        exponent = growth(scene, float(seconds), random.normal(size=4))[0] / float(seconds)
        found.append((energy_above_rest(scene), exponent))
        print(f"scene {k}: energy {found[-1][0]:.2f}, exponent {exponent:+.3f} 1/s")

    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot
    figure, axes = pyplot.subplots(figsize=(6, 3.6), constrained_layout=True)
    axes.plot(*np.transpose(found), "o", markersize=4)
    axes.set(xlabel="energy above rest / |energy at rest|", ylabel="largest Lyapunov exponent (1/s)")
    axes.grid(alpha=0.3)
    figure.savefig(picture, dpi=90)


if __name__ == "__main__":
    main()
